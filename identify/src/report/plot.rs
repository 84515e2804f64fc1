//! Plots that a reader can zoom into: numbers inside the page, drawn by the script at its end; a
//! still picture where scripts do not run.
//!
//! A hundred lines of script instead of a plotting library: every report carries them, and a
//! library would make each of them megabytes long.

use super::markup::escape;
use serde::{Serialize, Serializer};

/// An axis.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Axis {
    /// Quantity and unit.
    pub label: String,
    /// Whether it is logarithmic.
    pub log: bool,
}

impl Axis {
    pub(crate) fn linear(label: impl Into<String>) -> Self {
        Self {
            label: label.into(),
            log: false,
        }
    }

    pub(crate) fn logarithmic(label: impl Into<String>) -> Self {
        Self {
            label: label.into(),
            log: true,
        }
    }
}

/// What is drawn in a panel.
#[derive(Debug, Clone, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub(crate) enum Series {
    /// Points joined.
    Line(Points),
    /// The same, dashed.
    Dashes(Points),
    /// Points alone.
    Dots(Points),
    /// What lies between two curves.
    Band {
        name: String,
        colour: &'static str,
        #[serde(serialize_with = "abscissa")]
        x: Vec<f64>,
        #[serde(serialize_with = "rounded")]
        low: Vec<f64>,
        #[serde(serialize_with = "rounded")]
        high: Vec<f64>,
    },
}

/// Points under a name; without one they are not in the legend.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Points {
    pub name: String,
    pub colour: &'static str,
    #[serde(serialize_with = "abscissa")]
    pub x: Vec<f64>,
    /// What is not finite is a gap.
    #[serde(serialize_with = "rounded")]
    pub y: Vec<f64>,
}

/// Numbers to five digits: more than any screen shows, in a third of the letters.
fn rounded<S: Serializer>(values: &[f64], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(values.iter().map(|&value| short(value, 5)))
}

/// `value` to so many significant digits.
fn short(value: f64, digits: usize) -> f64 {
    format!("{value:.*e}", digits - 1).parse().unwrap_or(value)
}

/// Evenly spaced values as three numbers, others to seven digits: a time to 10 µs in a minute.
fn abscissa<S: Serializer>(x: &[f64], serializer: S) -> Result<S::Ok, S::Error> {
    #[derive(Serialize)]
    struct Even {
        from: f64,
        step: f64,
        count: usize,
    }
    if let ([from, .., to], true) = (x, x.len() > 3) {
        let step = (to - from) / (x.len() - 1) as f64;
        let even = (0..)
            .zip(x)
            .all(|(k, value): (i32, _)| (value - (from + f64::from(k) * step)).abs() < 1e-3 * step);
        if even {
            let count = x.len();
            return Even {
                from: *from,
                step,
                count,
            }
            .serialize(serializer);
        }
    }
    serializer.collect_seq(x.iter().map(|&value| short(value, 7)))
}

/// A vertical line with a name.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Mark {
    pub x: f64,
    pub name: String,
}

/// One pair of axes.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Panel {
    pub x: Axis,
    pub y: Axis,
    pub series: Vec<Series>,
    pub marks: Vec<Mark>,
}

/// Colours that readers of all kinds can tell apart (Okabe & Ito 2008).
pub(crate) const BLACK: &str = "#000000";
pub(crate) const BLUE: &str = "#0072b2";
pub(crate) const VERMILLION: &str = "#d55e00";
pub(crate) const GREEN: &str = "#009e73";
pub(crate) const GREY: &str = "#888888";

/// A figure of `panels` below each other; `still` (SVG) is shown where scripts do not run. `id` is
/// the figure's own in its page.
pub(crate) fn plot(id: &str, panels: &[Panel], still: &str, caption: &str) -> String {
    let numbers = serde_json::to_string(panels).expect("numbers and strings");
    // no letter of the markup inside a script
    let numbers = numbers.replace('<', "\\u003c").replace('>', "\\u003e");
    let still = still.replacen(r#" xmlns="http://www.w3.org/2000/svg""#, "", 1);
    format!(
        "<figure class=\"plot\" id=\"{id}\">\n<script type=\"application/json\">{numbers}</script>\n\
         <noscript>\n{still}</noscript>\n<figcaption>{} Drag to zoom, double click to see all.\
         </figcaption>\n</figure>\n",
        escape(caption)
    )
}

/// What draws the plots: once, at the end of a page.
pub(crate) fn script() -> String {
    format!("<script>\n{}</script>\n", include_str!("plot.js"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn even_values_are_three_numbers_and_what_is_not_finite_is_a_gap() {
        let json = |x: Vec<f64>| {
            let y = vec![f64::NAN, 1.0 / 3.0, 2.0, 1.234_567_8e-7];
            serde_json::to_string(&Points {
                name: String::new(),
                colour: BLACK,
                x,
                y,
            })
            .expect("numbers")
        };
        let even = json((0..4).map(|k| 2.0 + 0.005 * f64::from(k)).collect());
        assert!(even.contains(r#""x":{"from":2.0,"step":0.005"#), "{even}");
        assert!(
            even.ends_with(r#""y":[null,0.33333,2.0,1.2346e-7]}"#),
            "{even}"
        );
        let uneven = json(vec![0.0, 1.0, 2.0, 4.0]);
        assert!(uneven.contains(r#""x":[0.0,1.0,2.0,4.0]"#), "{uneven}");
    }
}
