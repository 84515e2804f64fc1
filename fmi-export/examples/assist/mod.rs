//! What a steering assist is made of besides its law: a clock that samples, sensors that count, a
//! watch over them, and a motor. Both assists of these examples are built from it.

mod clock;
mod description;
mod drive;
mod motor;
mod sensor;

pub use description::describe;
pub use drive::{Drive, Settings};
pub use sensor::quantised;

/// [`fmi_export::variables!`] with the rows that every assist has, after its own.
macro_rules! variables {
    ($(#[$outer:meta])* $vis:vis struct $Name:ident { $($own:tt)* }) => {
        fmi_export::variables! {
            $(#[$outer])*
            $vis struct $Name {
                $($own)*
                sample_time: f64 = 0.005, Parameter Fixed, unit "s", in [1e-4, 0.1], "Sampling period of sensors and law, counted from the start time";
                dead_time: f64 = 0.005, Parameter Fixed, unit "s", in [0.0, 0.1], "Dead time from sample to motor, a multiple of sample_time, of which it can be 16 at most";
                torque_limit: f64 = 3.0, Parameter Tunable, unit "N.m", in [0.0, 100.0], "Largest torque asked of the motor; 3 N m are less than a hand on the bar has";
                torque_rate_limit: f64 = 200.0, Parameter Tunable, unit "N.m/s", in [0.1, 1e5], "Fastest change of the torque asked of the motor, also on its way to 0 after a fault";
                motor_time_constant: f64 = 0.01, Parameter Tunable, unit "s", in [0.0, 1.0], "Time constant of the motor's torque, 0 at once";
                stale_time: f64 = 0.1, Parameter Tunable, unit "s", in [0.001, 10.0], "How long the sensors may say the same, to the last bit, while the law wants a torque";
                assist_torque: f64 = 0.0, Output Continuous, unit "N.m", "Torque of the motor on the fork, left positive";
                fault: bool = false, Output Discrete, "Whether the sensors say nothing: no numbers, or for too long the same";
                time: f64 = 0.0, Independent Continuous, unit "s", "Time";
            }
        }

        impl $Name {
            /// What the drive has to know of the rows above.
            fn settings(&self) -> super::assist::Settings {
                super::assist::Settings {
                    sample_time: self.sample_time,
                    dead_time: self.dead_time,
                    torque_limit: self.torque_limit,
                    torque_rate_limit: self.torque_rate_limit,
                    motor_time_constant: self.motor_time_constant,
                    stale_time: self.stale_time,
                }
            }
        }
    };
}
pub(crate) use variables;
