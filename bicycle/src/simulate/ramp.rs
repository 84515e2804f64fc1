//! Inputs that run straight in time.

use crate::state::Input;
use serde::{Deserialize, Serialize};

/// Inputs `u(t) = value + slope · (t − since)`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) struct Ramp {
    /// Their values at `since`.
    pub value: Input,
    /// Their rates of change [1/s].
    pub slope: Input,
    /// When they had these values [s].
    pub since: f64,
}

impl Ramp {
    /// Inputs that stay as they are from `since` [s] on.
    pub fn constant(value: Input, since: f64) -> Self {
        Self {
            value,
            slope: Input::ZERO,
            since,
        }
    }

    /// The inputs at time `t` [s]. One of slope zero is handed out as it was set, to the last bit.
    #[inline]
    pub fn at(&self, t: f64) -> Input {
        let slope = self.slope.to_array();
        if slope == [0.0; Input::LEN] {
            return self.value;
        }
        let (value, elapsed) = (self.value.to_array(), t - self.since);
        Input::from_array(std::array::from_fn(|i| {
            if slope[i] == 0.0 {
                value[i]
            } else {
                value[i] + slope[i] * elapsed
            }
        }))
    }

    /// Whether the inputs at `t` [s] are `value` and change by `slope`, to the last bit.
    pub fn reaches(&self, t: f64, value: &Input, slope: &Input) -> bool {
        self.at(t).has_bits_of(value) && self.slope.has_bits_of(slope)
    }
}
