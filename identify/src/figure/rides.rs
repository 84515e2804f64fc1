//! A ride as it was recorded: its channels over time with what is odd about them, and spectra.

use super::canvas::{
    BLACK, BLUE, GREY, Mark, ORANGE, PURPLE, SKY, VERMILLION, WIDTH, axes, px, stacked, stroke,
};
use super::{decimated, points, range, shown, stretches, words};
use crate::compare::Amplitudes;
use crate::inspect::Finding;
use crate::ride::{Ride, Span};
use plotters::element::{Circle, PathElement, Rectangle};
use plotters::series::LineSeries;
use plotters::style::{Color, RGBColor};

/// Where a finding is to be marked: in which channel, or in all; from when to when; how.
struct Place<'a> {
    channel: Option<&'a str>,
    span: Span,
    kind: Kind,
}

/// How a place is marked.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Standstill,
    Dropout,
    Clipped,
    Glitch,
}

impl Kind {
    const ALL: [Self; 4] = [Self::Standstill, Self::Dropout, Self::Clipped, Self::Glitch];

    fn colour(self) -> RGBColor {
        match self {
            Self::Standstill => GREY,
            Self::Dropout => PURPLE,
            Self::Clipped => ORANGE,
            Self::Glitch => VERMILLION,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Standstill => "standstill",
            Self::Dropout => "dropout",
            Self::Clipped => "clipped",
            Self::Glitch => "glitch",
        }
    }
}

/// The places that `findings` name.
fn marks(findings: &[Finding]) -> Vec<Place<'_>> {
    let mut marks = Vec::new();
    let mut mark = |channel, span: &Span, kind| {
        marks.push(Place {
            channel,
            span: *span,
            kind,
        });
    };
    for finding in findings {
        match finding {
            Finding::Standstill { spans } => {
                for span in spans {
                    mark(None, span, Kind::Standstill);
                }
            }
            Finding::Dropout { channels, span, .. } => {
                for channel in channels {
                    mark(Some(*channel), span, Kind::Dropout);
                }
            }
            Finding::Clipped { channel, span, .. } => mark(Some(*channel), span, Kind::Clipped),
            Finding::Glitch { channel, at, .. } => mark(Some(*channel), at, Kind::Glitch),
            _ => {}
        }
    }
    marks
}

/// The channels of `ride` over time, a panel each, and in them what `findings` say of a place.
pub fn channels(ride: &Ride, findings: &[Finding]) -> String {
    let marks = marks(findings);
    let kinds = Kind::ALL.into_iter();
    let seen = kinds.filter(|kind| marks.iter().any(|mark| mark.kind == *kind));
    let entry = |kind: Kind| {
        let (colour, name) = (kind.colour(), kind.name().to_owned());
        match kind {
            Kind::Glitch => (Mark::Dot(colour), name),
            _ => (Mark::Area(colour.mix(0.3)), name),
        }
    };
    let entries: Vec<_> = seen.map(entry).collect();
    let all: Vec<_> = ride.channels().collect();
    let time: Vec<f64> = (0..ride.len()).map(|i| ride.time(i)).collect();
    let x = time.first().copied().unwrap_or(0.0)..time.last().copied().unwrap_or(1.0);
    // a stretch of a sample or two is to be seen as well
    let least = (x.end - x.start) / f64::from(WIDTH);
    stacked(&entries, all.len(), |nth, panel| {
        let (row, samples) = all[nth];
        let (factor, unit) = shown(row.unit.symbol);
        let signal = points(&time, samples.iter().map(|y| factor * y));
        let y = range(signal.iter().map(|point| point.1));
        let x_label = (nth + 1 == all.len()).then_some("time [s]");
        let y_label = format!("{} [{unit}]", words(row.name));
        let mut chart = axes(panel, x_label, x.clone(), &y_label, y.clone())?;
        let here = marks
            .iter()
            .filter(|mark| mark.channel.is_none_or(|c| c == row.name));
        let (dots, areas): (Vec<_>, Vec<_>) = here.partition(|mark| mark.kind == Kind::Glitch);
        for mark in areas {
            let stop = mark.span.stop.max(mark.span.start + least);
            let corners = [(mark.span.start, y.start), (stop, y.end)];
            chart.draw_series([Rectangle::new(
                corners,
                mark.kind.colour().mix(0.3).filled(),
            )])?;
        }
        let columns = decimated(&signal, &x, WIDTH as usize);
        chart.draw_series(LineSeries::new(columns, stroke(BLACK.mix(0.8), 0.9)))?;
        for mark in dots {
            let at = signal.iter().find(|point| point.0 == mark.span.start);
            let dot = |at: &(f64, f64)| Circle::new(*at, px(4.0), mark.kind.colour().filled());
            chart.draw_series(at.map(dot))?;
        }
        Ok(())
    })
}

/// Amplitude spectra, a panel each, and the lines among `findings`.
pub fn lines(spectra: &[Amplitudes], findings: &[Finding]) -> String {
    let lines: Vec<f64> = findings
        .iter()
        .filter_map(|finding| match finding {
            Finding::Line { frequency, .. } => Some(*frequency),
            _ => None,
        })
        .collect();
    let mut entries = vec![(
        Mark::Line(BLUE),
        "residual of the moving average".to_owned(),
    )];
    if !lines.is_empty() {
        entries.push((Mark::Line(SKY), "line".into()));
    }
    stacked(&entries, spectra.len(), |nth, panel| {
        let Amplitudes {
            channel,
            unit,
            frequency,
            amplitude,
            ..
        } = &spectra[nth];
        let (factor, unit) = shown(unit);
        let curve = points(frequency, amplitude.iter().map(|a| factor * a));
        let top = range(curve.iter().map(|point| point.1)).end;
        let x = range(frequency.iter().copied());
        let x_label = (nth + 1 == spectra.len()).then_some("frequency [Hz]");
        let y_label = format!("{} [{unit}]", words(channel));
        let mut chart = axes(panel, x_label, x, &y_label, 0.0..top)?;
        for line in &lines {
            let ends = [(*line, 0.0), (*line, top)];
            chart.draw_series([PathElement::new(ends, stroke(SKY.into(), 3.0))])?;
        }
        for stretch in stretches(frequency) {
            let piece = curve[stretch].iter().copied();
            chart.draw_series(LineSeries::new(piece, stroke(BLUE.into(), 1.3)))?;
        }
        Ok(())
    })
}
