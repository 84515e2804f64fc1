//! Wrong values: of no variable, of another type, out of range, not finite.

use crate::expect;
use fmi2::{fmi2Error, fmi2OK, fmi2Status, fmi2String};
use model_description::{Causality, ScalarVariable, VariableType};
use std::ptr::null;
use tests::symbols::*;
use tests::{Slave, State, bicycle};

const SETTABLE: [State; 3] = [
    State::Instantiated,
    State::Initialization,
    State::StepComplete,
];

fn variables() -> impl Iterator<Item = &'static ScalarVariable> {
    bicycle().variables.iter()
}

#[test]
fn value_references_of_no_variable() {
    let count = bicycle().variables.len() as u32;
    for state in SETTABLE {
        let slave = &mut Slave::reach(state);
        for wrong in [count, count + 1, u32::MAX] {
            let what = format!("reference {wrong} in {state:?}");
            let vr = &raw const wrong;
            let (mut real, mut integer, mut text) = (0.0, 0, null());
            let (real, integer, text) = (&raw mut real, &raw mut integer, &raw mut text);
            let (one, word) = (1, c"x".as_ptr());
            let (one, word) = (&raw const one, &raw const word);
            let mut check = |call: &dyn Fn(&Slave) -> fmi2Status| {
                expect(slave, &what, fmi2Error, |s| call(s));
            };
            // SAFETY: one element each.
            unsafe {
                check(&|s| fmi2SetReal(s.c, vr, 1, real));
                check(&|s| fmi2SetInteger(s.c, vr, 1, integer));
                check(&|s| fmi2SetBoolean(s.c, vr, 1, integer));
                check(&|s| fmi2SetString(s.c, vr, 1, word));
                check(&|s| fmi2SetRealInputDerivatives(s.c, vr, 1, one, real));
                check(&|s| fmi2GetReal(s.c, vr, 1, real));
                check(&|s| fmi2GetInteger(s.c, vr, 1, integer));
                check(&|s| fmi2GetBoolean(s.c, vr, 1, integer));
                check(&|s| fmi2GetString(s.c, vr, 1, text));
                check(&|s| fmi2GetDirectionalDerivative(s.c, vr, 1, null(), 0, null(), real));
                check(&|s| fmi2GetDirectionalDerivative(s.c, null(), 0, vr, 1, real, real));
                check(&|s| fmi2GetRealOutputDerivatives(s.c, vr, 1, one, real));
            }
        }
    }
}

#[test]
fn every_variable_through_the_functions_of_another_type() {
    for state in SETTABLE {
        let slave = &mut Slave::reach(state);
        for variable in variables() {
            let vr = &raw const variable.value_reference;
            let is_real = matches!(variable.variable_type, VariableType::Real(_));
            let (mut real, mut integer, mut text) = (1.0, 1, null());
            let (real, integer, text) = (&raw mut real, &raw mut integer, &raw mut text);
            let word = c"x".as_ptr();
            let word: *const fmi2String = &raw const word;
            let what = format!("{} in {state:?}", variable.name);
            let mut check = |call: &dyn Fn(&Slave) -> fmi2Status| {
                expect(slave, &what, fmi2Error, |s| call(s));
            };
            // SAFETY: one element each.
            unsafe {
                check(&|s| fmi2SetBoolean(s.c, vr, 1, integer));
                check(&|s| fmi2SetString(s.c, vr, 1, word));
                check(&|s| fmi2GetBoolean(s.c, vr, 1, integer));
                check(&|s| fmi2GetString(s.c, vr, 1, text));
                if is_real {
                    check(&|s| fmi2SetInteger(s.c, vr, 1, integer));
                    check(&|s| fmi2GetInteger(s.c, vr, 1, integer));
                } else {
                    check(&|s| fmi2SetReal(s.c, vr, 1, real));
                    check(&|s| fmi2GetReal(s.c, vr, 1, real));
                }
            }
        }
    }
}

#[test]
fn no_variable_takes_what_is_not_finite_or_out_of_its_range() {
    for state in SETTABLE {
        let slave = &mut Slave::reach(state);
        for variable in variables() {
            let VariableType::Real(real) = &variable.variable_type else {
                continue;
            };
            let beyond = [real.min.map(f64::next_down), real.max.map(f64::next_up)];
            let wrong = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
            for value in wrong.into_iter().chain(beyond.into_iter().flatten()) {
                let what = format!("{} = {value} in {state:?}", variable.name);
                expect(slave, &what, fmi2Error, |s| s.set(&variable.name, value));
            }
        }
        for choice in [i32::MIN, -1, 0, 100, i32::MAX] {
            let vr = Slave::reference("formulation");
            expect(slave, "formulation", fmi2Error, |s| {
                // SAFETY: one element each.
                unsafe { fmi2SetInteger(s.c, &raw const vr, 1, &raw const choice) }
            });
        }
    }
}

#[test]
fn one_wrong_value_among_many_refuses_all() {
    let references = ["steer_torque", "rear_load", "speed"].map(Slave::reference);
    for state in SETTABLE {
        let slave = &mut Slave::reach(state);
        for wrong in 0..3 {
            let mut values = [1.0, 2.0, 3.0];
            values[wrong] = f64::NAN;
            // SAFETY: three elements each.
            expect(slave, "many", fmi2Error, |s| unsafe {
                fmi2SetReal(s.c, references.as_ptr(), 3, values.as_ptr())
            });
        }
    }
}

#[test]
fn slopes_are_for_inputs_and_of_order_one() {
    for state in SETTABLE {
        let slave = &mut Slave::reach(state);
        for variable in variables() {
            let (vr, slope) = (variable.value_reference, 0.25);
            let is_input = variable.causality == Causality::Input;
            for order in [i32::MIN, -1, 0, 1, 2, i32::MAX] {
                let expected = if is_input && order == 1 {
                    fmi2OK
                } else {
                    fmi2Error
                };
                let what = format!("order {order} of {} in {state:?}", variable.name);
                // SAFETY: one element each.
                expect(slave, &what, expected, |s| unsafe {
                    fmi2SetRealInputDerivatives(
                        s.c,
                        &raw const vr,
                        1,
                        &raw const order,
                        &raw const slope,
                    )
                });
            }
            for slope in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                expect(slave, &variable.name, fmi2Error, |s| {
                    s.ramp(&variable.name, slope)
                });
            }
        }
    }
}

#[test]
fn rates_are_of_outputs_and_of_order_one() {
    let slave = &mut Slave::reach(State::StepComplete);
    for variable in variables() {
        let (vr, mut rate) = (variable.value_reference, f64::NAN);
        let rate = &raw mut rate;
        let is_output = variable.causality == Causality::Output;
        for order in [i32::MIN, -1, 0, 1, 2, i32::MAX] {
            let expected = if is_output && order == 1 {
                fmi2OK
            } else {
                fmi2Error
            };
            let what = format!("order {order} of {}", variable.name);
            // SAFETY: one element each.
            expect(slave, &what, expected, |s| unsafe {
                fmi2GetRealOutputDerivatives(s.c, &raw const vr, 1, &raw const order, rate)
            });
        }
    }
}

/// FMI 2.0 §2.1.9: in initialization mode the unknowns are the initial unknowns, and known are
/// inputs and what has an exact start value; later the unknowns are outputs and derivatives, and
/// known are inputs and continuous states.
#[test]
fn directional_derivatives_are_of_the_unknowns_by_the_knowns_of_the_mode() {
    let structure = &bicycle().structure;
    let listed = |unknowns: &[model_description::Unknown], variable: &ScalarVariable| {
        unknowns
            .iter()
            .any(|unknown| bicycle().variables[unknown.index as usize - 1].name == variable.name)
    };
    let is_state = |variable: &ScalarVariable| {
        structure.derivatives.iter().any(|unknown| {
            let derivative = &bicycle().variables[unknown.index as usize - 1];
            let VariableType::Real(real) = &derivative.variable_type else {
                return false;
            };
            real.derivative
                .is_some_and(|state| bicycle().variables[state as usize - 1].name == variable.name)
        })
    };
    for state in [State::Initialization, State::StepComplete] {
        let slave = &mut Slave::reach(state);
        // what was set is worked in at the first look
        slave.get("roll");
        for variable in variables() {
            let initial = state == State::Initialization;
            let is_real = matches!(variable.variable_type, VariableType::Real(_));
            let unknown = is_real
                && if initial {
                    listed(&structure.initial_unknowns, variable)
                } else {
                    listed(&structure.outputs, variable) || listed(&structure.derivatives, variable)
                };
            let known = is_real
                && match variable.causality {
                    Causality::Input => true,
                    Causality::Parameter => initial,
                    _ => !initial && is_state(variable),
                };
            let vr = variable.value_reference;
            let (roll, torque) = (
                Slave::reference("roll_acceleration"),
                Slave::reference("steer_torque"),
            );
            let (seed, mut found) = (1.0, f64::NAN);
            let found = &raw mut found;
            let status = |right| if right { fmi2OK } else { fmi2Error };
            let what = format!("{} in {state:?}", variable.name);
            // SAFETY: one element each.
            unsafe {
                expect(slave, &format!("∂{what}"), status(unknown), |s| {
                    fmi2GetDirectionalDerivative(
                        s.c,
                        &raw const vr,
                        1,
                        &raw const torque,
                        1,
                        &raw const seed,
                        found,
                    )
                });
                expect(slave, &format!("/∂{what}"), status(known), |s| {
                    fmi2GetDirectionalDerivative(
                        s.c,
                        &raw const roll,
                        1,
                        &raw const vr,
                        1,
                        &raw const seed,
                        found,
                    )
                });
            }
        }
    }
}
