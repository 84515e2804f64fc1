//! Plots that a reader can zoom into: numbers inside the page, drawn by the script at its end; a
//! still picture where scripts do not run.
//!
//! A hundred lines of script instead of a plotting library: every report carries them, and a
//! library would make each of them megabytes long.

use super::markup::escape;
use serde::Serialize;

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
        x: Vec<f64>,
        low: Vec<f64>,
        high: Vec<f64>,
    },
}

/// Points under a name; without one they are not in the legend.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Points {
    pub name: String,
    pub colour: &'static str,
    pub x: Vec<f64>,
    /// What is not finite is a gap.
    pub y: Vec<f64>,
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
