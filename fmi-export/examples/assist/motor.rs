//! The motor: a limited command, its dead time, a first-order lag.

use super::Settings;
use fmi_export::serde::{Deserialize, Serialize};

/// The longest dead time, in samples.
pub const LONGEST_DEAD_TIME: usize = 16;

/// A motor and the command on its way to it.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(crate = "fmi_export::serde")]
pub struct Motor {
    /// The commands of this tick and of those before, newest first [N m].
    commands: [f64; LONGEST_DEAD_TIME + 1],
    /// The command that acts [N m].
    acting: f64,
    /// The torque on the fork [N m].
    pub torque: f64,
}

impl Motor {
    /// At a tick: moves the command towards `demand` [N m] as far as the limits allow.
    pub fn command(&mut self, demand: f64, s: &Settings) {
        let reach = s.torque_rate_limit * s.sample_time;
        let wanted = demand.clamp(-s.torque_limit, s.torque_limit);
        let command = self.commands[0] + (wanted - self.commands[0]).clamp(-reach, reach);
        self.commands.rotate_right(1);
        self.commands[0] = command;
        let samples = (s.dead_time / s.sample_time).round() as usize;
        self.acting = self.commands[samples.min(LONGEST_DEAD_TIME)];
    }

    /// Between ticks, for `time` [s]: the torque follows the command, T Ṁ + M = command. Exact, so
    /// that two short runs are a long one.
    pub fn run(&mut self, time: f64, s: &Settings) {
        if time > 0.0 {
            let left = (-time / s.motor_time_constant).exp();
            self.torque = self.acting + (self.torque - self.acting) * left;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Settings;
    use super::Motor;

    const SETTINGS: Settings = Settings {
        sample_time: 0.005,
        dead_time: 0.0,
        torque_limit: 8.0,
        torque_rate_limit: 200.0,
        motor_time_constant: 0.01,
        stale_time: 0.1,
    };

    #[test]
    fn the_torque_is_that_of_a_first_order_lag() {
        let at_once = Settings {
            torque_rate_limit: 1e5,
            ..SETTINGS
        };
        let mut motor = Motor::default();
        motor.command(2.0, &at_once);
        for _ in 0..7 {
            motor.run(0.003, &at_once);
        }
        let exact = 2.0 * (1.0 - (-0.021_f64 / 0.01).exp());
        // rounding of eight steps
        assert!((motor.torque - exact).abs() < 1e-14, "{}", motor.torque);
    }

    #[test]
    fn without_a_time_constant_it_follows_at_once() {
        let s = Settings {
            motor_time_constant: 0.0,
            ..SETTINGS
        };
        let mut motor = Motor::default();
        motor.command(0.5, &s);
        motor.run(1e-9, &s);
        assert_eq!(motor.torque, 0.5);
    }

    #[test]
    fn the_command_climbs_at_the_rate_limit_up_to_the_torque_limit() {
        let mut motor = Motor::default();
        for tick in 1..=12 {
            motor.command(-100.0, &SETTINGS);
            let expected = -f64::from(tick).min(8.0);
            assert_eq!(motor.acting, expected, "1 N m a tick, 8 N m at most");
        }
        for tick in 1..=8 {
            motor.command(0.0, &SETTINGS);
            assert_eq!(motor.acting, f64::from(tick) - 8.0, "and back as fast");
        }
    }

    #[test]
    fn the_dead_time_is_so_many_ticks() {
        for samples in [0, 1, 3, 16] {
            let s = Settings {
                dead_time: f64::from(samples) * SETTINGS.sample_time,
                ..SETTINGS
            };
            let mut motor = Motor::default();
            for tick in 0..20 {
                motor.command(0.7, &s);
                let expected = if tick < samples { 0.0 } else { 0.7 };
                assert_eq!(motor.acting, expected, "{samples} samples, tick {tick}");
            }
        }
    }
}
