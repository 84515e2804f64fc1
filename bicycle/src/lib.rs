//! The nonlinear bicycle with a rear load: parameters, equations, stepper.
