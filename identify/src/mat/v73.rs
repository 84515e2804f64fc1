//! MAT-files of version 7.3: HDF5 with a dataset a variable, dimensions in the other order, and a
//! group a struct. Each says its class in the attribute `MATLAB_class`.

use super::{Content, DEEPEST, SAVE, Variable, broken, vector};
use crate::error::Result;
use hdf5_pure::{AttrValue, DType, Dataset, File, Group};

/// The variables in `bytes`, of a file called `file`.
pub(super) fn variables(file: &str, bytes: &[u8]) -> Result<Vec<Variable>> {
    let read = || group(&File::from_bytes(bytes.to_vec())?.root(), 0);
    read().map_err(|cause| broken(file, &format!("HDF5 that cannot be read ({cause})")))
}

fn group(group: &Group, depth: usize) -> std::result::Result<Vec<Variable>, hdf5_pure::Error> {
    let mut variables = Vec::new();
    for (name, dataset) in group.iter_datasets()? {
        if !name.starts_with('#') {
            let content = content(&dataset)?;
            variables.push(Variable { name, content });
        }
    }
    for (name, inner) in group.iter_groups()? {
        // what MATLAB keeps for itself: #refs#, #subsystem#
        if name.starts_with('#') {
            continue;
        }
        let content = if depth < DEEPEST {
            Content::Struct(self::group(&inner, depth + 1)?)
        } else {
            Content::Other("a struct too deep in others".into())
        };
        variables.push(Variable { name, content });
    }
    Ok(variables)
}

fn content(dataset: &Dataset) -> std::result::Result<Content, hdf5_pure::Error> {
    let attributes = dataset.attrs()?;
    let class = match attributes.get("MATLAB_class") {
        Some(AttrValue::AsciiString(class) | AttrValue::String(class)) => class.as_str(),
        _ => "double",
    };
    if attributes.contains_key("MATLAB_empty") {
        return Ok(Content::Vector(Vec::new()));
    }
    Ok(match (class, dataset.dtype()?) {
        ("char", _) => Content::Other("text".into()),
        ("cell", _) => Content::Other("a cell array".into()),
        (_, DType::Compound(_)) => Content::Other("complex numbers".into()),
        (
            _,
            DType::F32
            | DType::F64
            | DType::I8
            | DType::I16
            | DType::I32
            | DType::I64
            | DType::U8
            | DType::U16
            | DType::U32
            | DType::U64,
        ) => {
            let mut shape = dataset.shape()?;
            shape.reverse();
            vector(dataset.read_f64()?, &shape)
        }
        (class, _) => Content::Other(format!("an object of MATLAB ({class}); {SAVE}")),
    })
}
