//! The linear system of coupled FMUs that list their states and declare directional derivatives.

use crate::error::Result;
use fmi_import::master::{Connection, Foreign, Participant};
use fmi_import::model_description::{ModelDescription, VariableType};
use fmi_import::{Fmu, Value};
use nalgebra::DMatrix;

/// Whether an FMU lists continuous states and declares directional derivatives.
pub fn lists_states(description: &ModelDescription) -> bool {
    let declares = description.co_simulation.as_ref();
    declares.is_some_and(|c| c.provides_directional_derivative) && !states(description).is_empty()
}

/// References of state derivatives and of their states (FMI 2.0 §2.2.8).
fn states(description: &ModelDescription) -> Vec<(u32, u32)> {
    let at = |index: u32| description.variables.get((index as usize).wrapping_sub(1));
    let pair = |index: u32| {
        let derivative = at(index)?;
        let VariableType::Real(real) = &derivative.variable_type else {
            return None;
        };
        Some((
            derivative.value_reference,
            at(real.derivative?)?.value_reference,
        ))
    };
    let listed = description.structure.derivatives.iter();
    listed.filter_map(|unknown| pair(unknown.index)).collect()
}

/// ẋ = A x + B u, y = C x + D u of one FMU as it starts, u and y what is connected.
pub struct Linear {
    a: DMatrix<f64>,
    b: DMatrix<f64>,
    c: DMatrix<f64>,
    d: DMatrix<f64>,
    /// Numbers of the connections that u and y belong to.
    inputs: Vec<usize>,
    outputs: Vec<usize>,
}

impl Linear {
    /// Of `fmu`, called `name`, with these start values.
    pub fn of(
        fmu: &Fmu,
        name: &str,
        starts: &[(String, Value)],
        connections: &[Connection],
    ) -> Result<Self> {
        let description = fmu.description();
        let reference = |variable: &str| {
            let found = description.variable(variable);
            found.map_or(0, |variable| variable.value_reference)
        };
        let mut inputs = Vec::new();
        let mut outputs = Vec::new();
        let (mut knowns, mut unknowns) = (Vec::new(), Vec::new());
        for (derivative, state) in states(description) {
            unknowns.push(derivative);
            knowns.push(state);
        }
        let order = knowns.len();
        for (n, connection) in connections.iter().enumerate() {
            if connection.target.participant == name {
                inputs.push(n);
                knowns.push(reference(&connection.target.variable));
            }
            if connection.source.participant == name {
                outputs.push(n);
                unknowns.push(reference(&connection.source.variable));
            }
        }
        let mut participant = Foreign::new(fmu, name, starts)?;
        participant.enter_initialization(0.0, 1.0)?;
        participant.exit_initialization()?;
        let mut all = DMatrix::zeros(unknowns.len(), knowns.len());
        for (n, known) in knowns.iter().enumerate() {
            let mut column = vec![0.0; unknowns.len()];
            let instance = participant.instance();
            instance.get_directional_derivative(&unknowns, &[*known], &[1.0], &mut column)?;
            all.set_column(n, &nalgebra::DVector::from_vec(column));
        }
        let part = |rows: (usize, usize), columns: (usize, usize)| {
            all.view((rows.0, columns.0), (rows.1, columns.1))
                .into_owned()
        };
        let (x, u, y) = ((0, order), (order, inputs.len()), (order, outputs.len()));
        Ok(Self {
            a: part(x, x),
            b: part(x, u),
            c: part(y, x),
            d: part(y, u),
            inputs,
            outputs,
        })
    }
}

/// The matrix of the coupled system without what only integrates others or does not move; none
/// where an algebraic loop has no solution. `factors` are those of the connections, from the unit of
/// the output to that of the input; what comes from participants not in `systems` is held.
pub fn coupled(systems: &[Linear], factors: &[f64]) -> Option<DMatrix<f64>> {
    let order = systems.iter().map(|system| system.a.nrows()).sum();
    let wires = factors.len();
    let mut a = DMatrix::zeros(order, order);
    let (mut b, mut c) = (DMatrix::zeros(order, wires), DMatrix::zeros(wires, order));
    let mut d = DMatrix::zeros(wires, wires);
    let mut first = 0;
    for system in systems {
        let n = system.a.nrows();
        a.view_mut((first, first), (n, n)).copy_from(&system.a);
        for (column, &wire) in system.inputs.iter().enumerate() {
            b.view_mut((first, wire), (n, 1))
                .copy_from(&system.b.column(column));
        }
        for (row, &wire) in system.outputs.iter().enumerate() {
            c.view_mut((wire, first), (1, n))
                .copy_from(&(system.c.row(row) * factors[wire]));
            for (column, &input) in system.inputs.iter().enumerate() {
                d[(wire, input)] = factors[wire] * system.d[(row, column)];
            }
        }
        first += n;
    }
    // u = factor · y on each wire: u = C x + D u
    let solved = (DMatrix::identity(wires, wires) - d).lu().solve(&c)?;
    Some(without_integrals(a + b * solved))
}

/// Leaves out, again and again, states on which nothing depends and states that do not move.
fn without_integrals(mut a: DMatrix<f64>) -> DMatrix<f64> {
    let idle = |a: &DMatrix<f64>| {
        let none = |v: f64| v == 0.0;
        (0..a.nrows())
            .find(|&n| a.column(n).iter().all(|v| none(*v)) || a.row(n).iter().all(|v| none(*v)))
    };
    while let Some(n) = idle(&a) {
        a = a.remove_row(n).remove_column(n);
    }
    a
}
