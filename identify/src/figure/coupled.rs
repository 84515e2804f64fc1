//! What travelled between participants, over time.

use super::canvas::{Mark, axes, stacked, stroke};
use super::{colours, decimated, points, range, shown};
use plotters::series::LineSeries;
use plotters::style::{Color, RGBColor};

/// A curve over time: its name, its unit, its values.
#[derive(Debug, Clone, Copy)]
pub struct Drawn<'a> {
    /// What it is called in the legend.
    pub name: &'a str,
    /// The unit its values are in; curves of one unit share a panel.
    pub unit: &'a str,
    /// One value for each time.
    pub values: &'a [f64],
}

/// Curves over `time` [s], a panel a unit.
pub fn coupled(time: &[f64], curves: &[Drawn]) -> String {
    let mut units: Vec<&str> = Vec::new();
    for curve in curves {
        if !units.contains(&curve.unit) {
            units.push(curve.unit);
        }
    }
    // each panel begins with the first colour
    let coloured: Vec<(&Drawn, RGBColor)> = (units.iter())
        .flat_map(|unit| {
            let of_unit = curves.iter().filter(move |curve| curve.unit == *unit);
            of_unit.zip(colours())
        })
        .collect();
    let entry = |(curve, colour): &(&Drawn, RGBColor)| {
        let (_, unit) = shown(curve.unit);
        (Mark::Line(*colour), format!("{} [{unit}]", curve.name))
    };
    let entries: Vec<(Mark, String)> = coloured.iter().map(entry).collect();
    let width = time.first().copied().unwrap_or(0.0)..time.last().copied().unwrap_or(1.0);
    stacked(&entries, units.len(), |nth, panel| {
        let (factor, unit) = shown(units[nth]);
        let here: Vec<_> = coloured
            .iter()
            .filter(|(curve, _)| curve.unit == units[nth])
            .map(|(curve, colour)| {
                let values = curve.values.iter().map(|value| factor * value);
                (points(time, values), *colour)
            })
            .collect();
        let height = range(here.iter().flat_map(|(points, _)| points).map(|p| p.1));
        let x = (nth + 1 == units.len()).then_some("time [s]");
        let mut chart = axes(panel, x, width.clone(), &format!("[{unit}]"), height)?;
        for (points, colour) in here {
            let thinned = decimated(&points, &width, 640);
            let line = LineSeries::new(thinned, stroke(colour.to_rgba(), 1.2));
            chart.draw_series(line)?;
        }
        Ok(())
    })
}
