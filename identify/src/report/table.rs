//! The table of parameters, as cells and as plain text.

use super::further;
use super::number::Numbers;
use super::words::{advice, misfit, work};
use crate::fit::Fit;
use crate::free::Free;
use crate::ride::base;
use crate::run::Run;
use crate::verdict::Estimate;
use std::fmt::Write as _;

/// Heads of the columns of [`cells`].
pub(super) const HEADS: [&str; 8] = [
    "parameter",
    "symbol",
    "estimate",
    "std. error",
    "95 % interval",
    "bounds",
    "verdict",
    "trades against",
];
/// Width of a line of text in a terminal.
const LINE: usize = 80;
/// What stands where there is nothing to say.
pub(crate) const NOTHING: &str = "–";

/// The symbol of a row of the tables.
fn symbol(name: &str) -> &'static str {
    Free::new(name).map_or("", |free| free.row.symbol)
}

/// An estimate as cells, in the order of [`HEADS`].
pub(super) fn cells(estimate: &Estimate) -> [String; HEADS.len()] {
    let Numbers {
        value,
        std_error,
        interval,
        bounds,
        unit,
    } = Numbers::of(estimate);
    let trades = match &estimate.trades_against[..] {
        [] => NOTHING.into(),
        names => names.join(", "),
    };
    let bound = if estimate.at_bound {
        ", at a bound"
    } else {
        ""
    };
    [
        estimate.label(),
        symbol(&estimate.name).into(),
        format!("{value} {unit}"),
        std_error.unwrap_or_else(|| NOTHING.into()),
        interval.unwrap_or_else(|| NOTHING.into()),
        bounds,
        format!("{}{bound}", estimate.verdict.name()),
        trades,
    ]
}

/// The table of parameters as plain text, ending in a line break; before it, where a parameter is
/// not determined, what would determine it.
pub fn table(fit: &Fit) -> String {
    let text = advice(fit).map_or_else(String::new, |advice| wrapped(&advice) + "\n");
    let rows: Vec<_> = std::iter::once(HEADS.map(str::to_owned))
        .chain(fit.parameters.iter().map(cells))
        .collect();
    text + &aligned(&rows)
}

/// `rows` as plain text, columns below each other.
pub(crate) fn aligned<const N: usize>(rows: &[[String; N]]) -> String {
    let widths: [usize; N] =
        std::array::from_fn(|c| rows.iter().map(|row| width(&row[c])).max().unwrap_or(0));
    let mut text = String::new();
    for row in rows {
        let mut line = String::new();
        for (cell, column) in row.iter().zip(widths) {
            let _ = write!(line, "{cell}{:1$}", "", column - width(cell) + 2);
        }
        text += line.trim_end();
        text.push('\n');
    }
    text.replace('\u{a0}', " ")
}

/// What a fit says in a terminal: [`table`], then how well the model explains the ride, how the
/// search ended, and what came of all that was asked besides.
pub fn summary(run: &Run) -> String {
    let fit = &run.fit;
    let mut text = table(fit) + "\n" + &wrapped(&misfit(fit));
    let several = fit.explained.len() > 1;
    for (ride, replay) in fit
        .explained
        .iter()
        .flat_map(|ride| ride.replays.iter().map(move |replay| (ride, replay)))
    {
        let of = if several {
            format!(" of {}", base(&ride.ride))
        } else {
            String::new()
        };
        let _ = writeln!(
            text,
            "variance accounted for in {}{of}: {:.0} %",
            replay.channel,
            100.0 * replay.variance_accounted_for
        );
    }
    for note in &fit.notes {
        text += &wrapped(&format!("note: {note}"));
    }
    text += &wrapped(&work(fit));
    for line in further::lines(run) {
        text += &wrapped(&line);
    }
    text
}

/// Columns that `text` takes in a terminal: combining marks, as the dot of θ̇, take none.
fn width(text: &str) -> usize {
    text.chars()
        .filter(|c| !('\u{300}'..='\u{36f}').contains(c))
        .count()
}

/// `text` broken between words, not between number and unit, every line ended.
pub(crate) fn wrapped(text: &str) -> String {
    let mut wrapped = String::new();
    let mut column = 0;
    for word in text.split(' ') {
        if column > 0 && column + 1 + width(word) > LINE {
            wrapped.push('\n');
            column = 0;
        }
        if column > 0 {
            wrapped.push(' ');
            column += 1;
        }
        wrapped += word;
        column += width(word);
    }
    wrapped.replace('\u{a0}', " ") + "\n"
}
