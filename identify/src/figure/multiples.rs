//! Small multiples: a panel for each pair of labels, some down, some across.

use super::canvas::{
    Area, BELOW, BLACK, Drawn, LEFT, LEFT_BARE, LINE, Mark, RIGHT, WIDTH, minus, panels, px,
    under_legend, write,
};

/// Height of a panel without its labels [px].
const HEIGHT: f64 = 112.0;

/// Height of the labels above them, apart from the legend [px].
const HEADS: f64 = 1.5 * LINE;

/// A panel among others.
pub(super) struct Place {
    /// Number of its row.
    pub(super) down: usize,
    /// Number of its column.
    pub(super) across: usize,
    /// Whether the labels of the x axis stand below it.
    pub(super) is_last: bool,
    /// Where words within it end, from its left [px].
    pub(super) right: f64,
}

/// Panels below a legend, `draw` in each.
pub(super) fn multiples(
    entries: &[(Mark, String)],
    (down, across): (&[String], &[String]),
    draw: impl Fn(&Area, &Place) -> Drawn,
) -> String {
    let columns = across.len().max(1) as f64;
    let beside = LEFT + RIGHT + (columns - 1.0) * (LEFT_BARE + RIGHT);
    let plot = ((f64::from(WIDTH) - beside) / columns).max(1.0);
    let left = |nth: usize| match nth {
        0 => 0.0,
        n => LEFT - LEFT_BARE + n as f64 * (LEFT_BARE + plot + RIGHT),
    };
    let height = HEADS + down.len() as f64 * (LINE + HEIGHT) + BELOW;
    under_legend(entries, height, |root| {
        for (nth, label) in across.iter().enumerate() {
            let bare = if nth == 0 { LEFT } else { LEFT_BARE };
            write(root, (left(nth) + bare, HEADS - LINE), &minus(label), BLACK)?;
        }
        let (_, rest) = root.split_vertically(px(HEADS));
        let lines = panels(&rest, down.len(), LINE + HEIGHT);
        for (nth_down, (line, label)) in lines.iter().zip(down).enumerate() {
            write(line, (LEFT, 0.0), &minus(label), BLACK)?;
            let (_, line) = line.split_vertically(px(LINE));
            for nth in 0..across.len() {
                let width = left(nth + 1) - left(nth);
                let size = (px(width) as u32, line.dim_in_pixel().1);
                let panel = line.clone().shrink((px(left(nth)), 0), size);
                let place = Place {
                    down: nth_down,
                    across: nth,
                    is_last: nth_down + 1 == down.len(),
                    right: width - RIGHT - 4.0,
                };
                draw(&panel, &place)?;
            }
        }
        Ok(())
    })
}
