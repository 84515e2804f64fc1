//! What the model leaves unexplained: residuals of windows, of bins and of frequency responses.

use super::markup;
use super::plot::{Axis, BLACK, BLUE, GREEN, GREY, Panel, Series, VERMILLION, plot};
use super::plots::points;
use super::words::words;
use crate::run::{Curve, Responded, Trace};
use crate::validate::residual::{BAND, Correlations, Left, whiteness};

/// Colours of channels.
const COLOURS: [&str; 4] = [BLUE, VERMILLION, GREEN, BLACK];
/// Mean ratio of power that an amplitude over its mean has, squared: E|Y|² = 4/π (E|Y|)².
const POWER: f64 = std::f64::consts::FRAC_PI_4;

/// The section, of all rides together; empty where there is nothing to look at.
pub(super) fn section(
    spectra: &[Vec<Curve>],
    traces: &[Vec<Trace>],
    responses: &[Vec<Responded>],
) -> String {
    let (panels, caption) = if !spectra.is_empty() {
        (bins(spectra), BINS)
    } else if !responses.is_empty() {
        (ratios(responses), RATIOS)
    } else {
        (lags(traces), WINDOWS)
    };
    if panels.is_empty() {
        return String::new();
    }
    markup::section("Residuals", &plot("residuals", &panels, "", caption))
}

const BINS: &str = "Power of each bin over what the fitted model expects, all rides, and its \
    quantiles against those of an exponential distribution, which it has where the model is true: \
    99 of 100 bins lie in the band, and the quantiles on the dashed line.";
const RATIOS: &str = "Measured over expected response in random errors of the bin: 99 of 100 lie in \
    the band where the model is true.";
const WINDOWS: &str = "Correlation of the residual with itself, all windows. 99 of 100 lags of a \
    white residual lie in the band; sensor noise is white, what the model misses is not. The free \
    starts of short windows take a little out of it.";

/// The name of a channel in each ride, with its colour.
fn channels<T>(rides: &[Vec<T>], name: fn(&T) -> &str) -> Vec<(&str, &'static str)> {
    let first = rides.iter().find(|ride| !ride.is_empty());
    let names = first.into_iter().flatten().map(name);
    names.zip(COLOURS.into_iter().cycle()).collect()
}

/// `y` between the ends of the band that holds a value with probability [`BAND`].
fn band(x: &[f64], (low, high): (f64, f64)) -> Series {
    let (least, most) = ends(x);
    Series::Band {
        name: "99 %".into(),
        colour: GREY,
        x: vec![least, most],
        low: vec![low; 2],
        high: vec![high; 2],
    }
}

fn ends(x: &[f64]) -> (f64, f64) {
    x.iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &v| {
            (low.min(v), high.max(v))
        })
}

/// Quantile of the exponential distribution of mean 1.
fn exponential(p: f64) -> f64 {
    -(1.0 - p).ln()
}

/// Power of each bin over the expected one, over frequency and as quantiles.
fn bins(rides: &[Vec<Curve>]) -> Vec<Panel> {
    let (mut over_frequency, mut quantiles, mut all) = (Vec::new(), Vec::new(), Vec::new());
    let mut largest = 1.0_f64;
    for (c, (name, colour)) in channels(rides, |curve| &curve.channel)
        .into_iter()
        .enumerate()
    {
        let (mut x, mut ratios) = (Vec::new(), Vec::new());
        for curve in rides.iter().filter_map(|ride| ride.get(c)) {
            x.extend_from_slice(&curve.frequency);
            let pairs = curve.measured.iter().zip(&curve.expected);
            ratios.extend(pairs.map(|(measured, mean)| POWER * (measured / mean).powi(2)));
        }
        all.extend_from_slice(&x);
        let name = words(name);
        over_frequency.push(Series::Dots(points(&name, colour, &x, ratios.clone())));
        ratios.sort_by(f64::total_cmp);
        let n = ratios.len() as f64;
        let at: Vec<f64> = (0..ratios.len())
            .map(|i| exponential((i as f64 + 0.5) / n))
            .collect();
        largest = at.last().map_or(largest, |&x| largest.max(x));
        quantiles.push(Series::Dots(points(&name, colour, &at, ratios)));
    }
    if all.is_empty() {
        return Vec::new();
    }
    let tail = 0.5 * (1.0 - BAND);
    over_frequency.insert(0, band(&all, (exponential(tail), exponential(1.0 - tail))));
    let line = vec![0.0, largest];
    quantiles.insert(
        0,
        Series::Dashes(points("true model", GREY, &line, line.clone())),
    );
    let panel = |x: Axis, y: Axis, series| Panel {
        x,
        y,
        series,
        marks: Vec::new(),
    };
    vec![
        panel(
            Axis::linear("frequency [Hz]"),
            Axis::logarithmic("power, over expected"),
            over_frequency,
        ),
        panel(
            Axis::linear("quantile of an exponential distribution"),
            Axis::linear("of the bins"),
            quantiles,
        ),
    ]
}

/// Autocorrelation of the residual of each channel.
fn lags(rides: &[Vec<Trace>]) -> Vec<Panel> {
    let mut panels = Vec::new();
    for (c, (name, colour)) in channels(rides, |trace| &trace.channel)
        .into_iter()
        .enumerate()
    {
        let own = || rides.iter().filter_map(|ride| ride.get(c));
        let residuals: Vec<Vec<f64>> = own().flat_map(Trace::residuals).collect();
        let parts: Vec<Left> = residuals.into_iter().map(Left::of).collect();
        let step = own().find_map(|trace| Some(trace.time.get(1)? - trace.time.first()?));
        let Some(step) = step.filter(|_| parts.iter().any(|part| part.residual.len() > 1)) else {
            continue;
        };
        let correlations = whiteness(&parts, step).correlations;
        panels.push(correlation(
            &format!("{}, autocorrelation", words(name)),
            "lag [s]",
            colour,
            &correlations,
        ));
    }
    panels
}

/// Correlations over lags with their band.
pub(super) fn correlation(
    label: &str,
    lag: &str,
    colour: &'static str,
    correlations: &Correlations,
) -> Panel {
    let Correlations {
        lag: x,
        value,
        band,
        ..
    } = correlations;
    Panel {
        x: Axis::linear(lag),
        y: Axis::linear(label),
        series: vec![
            Series::Band {
                name: "99 % without correlation".into(),
                colour: GREY,
                x: x.clone(),
                low: band.iter().map(|b| -b).collect(),
                high: band.clone(),
            },
            Series::Line(points("", colour, x, value.clone())),
            Series::Dots(points("residual", colour, x, value.clone())),
        ],
        marks: Vec::new(),
    }
}

/// Magnitudes and phases over the expected ones, in random errors.
fn ratios(rides: &[Vec<Responded>]) -> Vec<Panel> {
    let (mut magnitude, mut phase, mut all) = (Vec::new(), Vec::new(), Vec::new());
    for (c, (name, colour)) in channels(rides, |r| &r.channel).into_iter().enumerate() {
        for (k, response) in rides.iter().filter_map(|ride| ride.get(c)).enumerate() {
            let name = if k == 0 { words(name) } else { String::new() };
            let x = &response.frequency;
            let dots = |y: &[f64]| Series::Dots(points(&name, colour, x, y.to_vec()));
            magnitude.push(dots(&response.magnitude_residual));
            phase.push(dots(&response.phase_residual));
            all.extend_from_slice(x);
        }
    }
    if all.is_empty() {
        return Vec::new();
    }
    let wide = crate::distribution::normal_half_width(BAND);
    let panel = |label: &str, mut series: Vec<Series>| {
        series.insert(0, band(&all, (-wide, wide)));
        Panel {
            x: Axis::linear("frequency [Hz]"),
            y: Axis::linear(label),
            series,
            marks: Vec::new(),
        }
    };
    vec![
        panel("magnitude [random errors]", magnitude),
        panel("phase [random errors]", phase),
    ]
}
