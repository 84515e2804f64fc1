//! Courses and the rider's manner, as typed.

use crate::bicycles::admit;
use crate::error::{Error, Result};
use crate::unit;
use bicycle::Quantity;
use bicycle::course::Layout;
use bicycle::rider::Manner;

/// The course called `name`, for a bicycle of `wheelbase` [m], and the rider's manner, with rows of
/// either `set` as `name=value`.
pub fn plan(name: &str, set: &[String], wheelbase: f64) -> Result<(Layout, Manner)> {
    let mut all = Layout::all().into_iter();
    let mut layout = all.find(|layout| layout.name() == name).ok_or_else(|| {
        let known = Layout::all().map(|layout| layout.name());
        Error::unknown("course", name, known)
    })?;
    let mut manner = Manner::default();
    if let Some(row) = position(&layout, "wheelbase") {
        layout.set(row, wheelbase);
    }
    for text in set {
        assign(&mut layout, &mut manner, text)
            .map_err(|cause| cause.typed(format!("--course-set {text}")))?;
    }
    Ok((layout, manner))
}

fn assign(layout: &mut Layout, manner: &mut Manner, text: &str) -> Result<()> {
    let (name, value) = text.split_once('=').ok_or_else(|| Error::Form {
        expected: "NAME=VALUE",
        found: text.into(),
    })?;
    let read =
        |row: &Quantity| unit::parse(value, row.unit, row.name).and_then(|value| admit(row, value));
    if let Some(index) = position(layout, name) {
        layout.set(index, read(&layout.table()[index])?);
    } else if let Some(index) = Manner::index(name) {
        manner.set(index, read(&Manner::TABLE[index])?);
    } else {
        let rows = layout.table().iter().chain(Manner::TABLE);
        return Err(Error::unknown(
            "row of the course",
            name,
            rows.map(|row| row.name),
        ));
    }
    Ok(())
}

/// Where `layout` has the row called `name`.
fn position(layout: &Layout, name: &str) -> Option<usize> {
    layout.table().iter().position(|row| row.name == name)
}
