//! The paper under the figures: panels, axes, legends, colours.

use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::ops::Range;

/// Width of every figure [px]: a line of text on A4 paper.
pub(super) const WIDTH: u32 = 720;
/// Units of the backend in a pixel: it knows whole numbers only, too coarse for a thin curve.
const FINE: f64 = 10.0;
/// Height of a panel, and of the labels below the last [px].
pub(super) const PANEL: f64 = 190.0;
pub(super) const BELOW: f64 = 46.0;
/// Height of a line of text [px], and its size, of which the backend makes pixels over 1.24.
pub(super) const LINE: f64 = 20.0;
const TEXT: f64 = 12.0 * 1.24;
/// Width of an average letter [px]: the backend cannot measure text.
pub(super) const LETTER: f64 = 6.2;

/// The palette of Okabe and Ito (2008), which the colour-blind can tell apart.
pub(super) const BLACK: RGBColor = RGBColor(0, 0, 0);
pub(super) const BLUE: RGBColor = RGBColor(0, 114, 178);
pub(super) const VERMILLION: RGBColor = RGBColor(213, 94, 0);
pub(super) const ORANGE: RGBColor = RGBColor(230, 159, 0);
pub(super) const GREEN: RGBColor = RGBColor(0, 158, 115);
pub(super) const PURPLE: RGBColor = RGBColor(204, 121, 167);
pub(super) const SKY: RGBColor = RGBColor(86, 180, 233);
pub(super) const GREY: RGBColor = RGBColor(110, 110, 110);

pub(super) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
pub(super) type Chart<'a, 'b> =
    ChartContext<'b, SVGBackend<'a>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;
pub(super) type Drawn<T = ()> = Result<T, DrawingAreaErrorKind<std::io::Error>>;

/// A figure of `height` [px].
pub(super) fn svg(height: f64, draw: impl FnOnce(&Area) -> Drawn) -> String {
    let (width, height) = (f64::from(WIDTH), height.round());
    let size = (px(width) as u32, px(height) as u32);
    let mut text = String::new();
    let root = SVGBackend::with_string(&mut text, size).into_drawing_area();
    draw(&root)
        .and_then(|()| root.present())
        .expect("a string takes all");
    drop(root);
    let (fine, shown) = (
        format!(r#"width="{}" height="{}""#, size.0, size.1),
        format!(r#"width="{width}" height="{height}""#),
    );
    text.replacen(&fine, &shown, 1)
}

/// A figure of `height` [px] below a legend.
pub(super) fn under_legend(
    entries: &[(Mark, String)],
    height: f64,
    draw: impl FnOnce(&Area) -> Drawn,
) -> String {
    let places = places(entries);
    let top = places.last().map_or(0.0, |place| place.1 + LINE);
    svg(top + height, |root| {
        let (legend, rest) = root.split_vertically(px(top));
        for ((mark, label), at) in entries.iter().zip(places) {
            mark.draw(&legend, at, label)?;
        }
        draw(&rest)
    })
}

/// A figure of `count` panels below a legend; `draw` is told which panel and where.
pub(super) fn stacked(
    entries: &[(Mark, String)],
    count: usize,
    draw: impl Fn(usize, &Area) -> Drawn,
) -> String {
    under_legend(entries, count as f64 * PANEL + BELOW, |rest| {
        for (nth, panel) in panels(rest, count, PANEL).iter().enumerate() {
            draw(nth, panel)?;
        }
        Ok(())
    })
}

/// Panels of one `height` [px] above each other, the last with room for the labels of the x axis.
pub(super) fn panels<'a>(area: &Area<'a>, count: usize, height: f64) -> Vec<Area<'a>> {
    let breaks: Vec<i32> = (1..count).map(|nth| px(nth as f64 * height)).collect();
    if count == 0 {
        Vec::new()
    } else {
        area.split_by_breakpoints([0; 0], breaks)
    }
}

pub(super) fn axes<'a, 'b>(
    area: &'b Area<'a>,
    x_label: Option<&str>,
    x: Range<f64>,
    y_label: &str,
    y: Range<f64>,
) -> Drawn<Chart<'a, 'b>> {
    grid(area, (x_label, Some(y_label)), (x, y), (12, 6))
}

/// Room of a panel beside its plot [px]: left of it with and without numbers, and right of it.
pub(super) const LEFT: f64 = 66.0;
pub(super) const LEFT_BARE: f64 = 10.0;
pub(super) const RIGHT: f64 = 14.0;

/// Axes with about so many numbers each; one without a label has the ticks only, as have panels
/// above and beside others.
pub(super) fn grid<'a, 'b>(
    area: &'b Area<'a>,
    (x_label, y_label): (Option<&str>, Option<&str>),
    (x, y): (Range<f64>, Range<f64>),
    numbers: (usize, usize),
) -> Drawn<Chart<'a, 'b>> {
    let margin = 8.0;
    let left = if y_label.is_some() { LEFT } else { LEFT_BARE };
    let mut chart = ChartBuilder::on(area)
        .margin_top(px(8.0))
        .margin_right(px(RIGHT))
        .margin_bottom(px(6.0))
        .margin_left(px(margin))
        .y_label_area_size(px(left - margin))
        .x_label_area_size(px(if x_label.is_some() { BELOW } else { 2.0 }))
        .build_cartesian_2d(x, y)?;
    let of_x = |x: &f64| x_label.map_or_else(String::new, |_| tick(x));
    let of_y = |y: &f64| y_label.map_or_else(String::new, |_| tick(y));
    let (text, thin) = (("sans-serif", px(TEXT)), stroke(BLACK.mix(0.7), 0.8));
    let mut mesh = chart.configure_mesh();
    mesh.light_line_style(TRANSPARENT)
        .bold_line_style(stroke(BLACK.mix(0.1), 0.7))
        .axis_style(thin)
        .label_style(text)
        .axis_desc_style(text)
        .set_all_tick_mark_size(px(4.0))
        .x_labels(numbers.0)
        .y_labels(numbers.1)
        .x_label_formatter(&of_x)
        .y_label_formatter(&of_y);
    if let Some(label) = x_label {
        mesh.x_desc(label);
    }
    if let Some(label) = y_label {
        mesh.y_desc(label);
    }
    mesh.draw()?;
    Ok(chart)
}

/// A number on an axis, rid of round-off.
#[expect(
    clippy::trivially_copy_pass_by_ref,
    reason = "the signature of a formatter of labels"
)]
fn tick(value: &f64) -> String {
    // + 0 turns −0 into 0
    minus(&format!("{}", (value * 1e9).round() / 1e9 + 0.0))
}

/// `number` with a real minus.
pub(super) fn minus(number: &str) -> String {
    number.replace('-', "−")
}

/// The sample beside a name in a legend.
pub(super) enum Mark {
    Line(RGBColor),
    Dot(RGBColor),
    Area(RGBAColor),
}

impl Mark {
    /// Width of the sample with its distance to the text [px].
    pub(super) const WIDTH: f64 = 26.0;

    pub(super) fn draw(&self, area: &Area, (x, y): (f64, f64), label: &str) -> Drawn {
        let middle = y + 0.5 * LINE;
        let at = |x: f64, y: f64| (px(x), px(y));
        match self {
            Self::Line(colour) => {
                let ends = [at(x, middle), at(x + 20.0, middle)];
                area.draw(&PathElement::new(ends, stroke((*colour).into(), 2.0)))?;
            }
            Self::Dot(colour) => {
                area.draw(&Circle::new(at(x + 10.0, middle), px(3.0), colour.filled()))?;
            }
            Self::Area(colour) => {
                let corners = [at(x, middle - 5.0), at(x + 20.0, middle + 5.0)];
                area.draw(&Rectangle::new(corners, colour.filled()))?;
            }
        }
        write(area, (x + Self::WIDTH, y), label, BLACK)
    }
}

/// Where the entries of a legend go, left to right and line by line [px].
fn places(entries: &[(Mark, String)]) -> Vec<(f64, f64)> {
    let (mut x, mut y) = (LEFT, 2.0);
    let width = |label: &str| Mark::WIDTH + LETTER * label.chars().count() as f64 + 22.0;
    let place = |(_, label): &(Mark, String)| {
        if x > LEFT && x + width(label) > f64::from(WIDTH) {
            (x, y) = (LEFT, y + LINE);
        }
        let at = (x, y);
        x += width(label);
        at
    };
    entries.iter().map(place).collect()
}

/// Writes `text` in a line whose upper left corner is `at` [px].
pub(super) fn write(area: &Area, at: (f64, f64), text: &str, colour: RGBColor) -> Drawn {
    let style = ("sans-serif", px(TEXT))
        .into_text_style(area)
        .color(&colour)
        .pos(Pos::new(HPos::Left, VPos::Center));
    area.draw(&Text::new(
        text.to_owned(),
        (px(at.0), px(at.1 + 0.5 * LINE)),
        style,
    ))
}

pub(super) fn px(pixels: f64) -> i32 {
    (pixels * FINE).round() as i32
}

pub(super) fn stroke(colour: RGBAColor, pixels: f64) -> ShapeStyle {
    colour.stroke_width(px(pixels) as u32)
}
