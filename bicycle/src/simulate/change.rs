//! What may change under way, and when it is refused.

use super::Simulation;
use super::ramp::Ramp;
use super::stability::{Refusal, StableSpeeds};
use crate::dynamics::Bicycle;
use crate::parameters::Parameters;
use crate::quantity::Variability;
use crate::state::Input;

impl Simulation {
    /// Sets the inputs from here on; they stay as they are.
    pub fn set_input(&mut self, input: Input) -> Result<(), Refusal> {
        self.drive(input, Input::ZERO)
    }

    /// Sets the tunable parameters from here on; fixed rows keep the values they started with.
    pub fn set_parameters(&mut self, parameters: &Parameters) -> Result<(), Refusal> {
        self.set(parameters, self.input(), *self.input_slope())
    }

    /// Sets tunable parameters, inputs and the rates at which these change from here on (`slope`,
    /// each row in its unit per second), refused or taken together. Of a speed only its present
    /// value is checked: see [`Self::check_until`].
    pub fn set(
        &mut self,
        parameters: &Parameters,
        input: Input,
        slope: Input,
    ) -> Result<(), Refusal> {
        if let Some(parameters) = self.retuned(parameters) {
            let bicycle = Bicycle::new(&parameters, self.bicycle.formulation);
            self.stable = StableSpeeds::around(&bicycle, input.speed)?;
            self.bicycle = bicycle;
            self.settle();
        }
        self.drive(input, slope)
    }

    /// The parameters in force with the tunable rows of `parameters`, where that is a change.
    fn retuned(&self, parameters: &Parameters) -> Option<Parameters> {
        if parameters.has_bits_of(&self.bicycle.p) {
            return None;
        }
        let (old, new) = (self.bicycle.p.to_array(), parameters.to_array());
        let tuned = Parameters::from_array(std::array::from_fn(|i| {
            match Parameters::TABLE[i].variability {
                Variability::Fixed => old[i],
                Variability::Tunable | Variability::Continuous => new[i],
            }
        }));
        (!tuned.has_bits_of(&self.bicycle.p)).then_some(tuned)
    }

    fn drive(&mut self, input: Input, slope: Input) -> Result<(), Refusal> {
        if self.ramp.reaches(self.instant(), &input, &slope) {
            return Ok(());
        }
        let course = |u: &Input, slope: &Input| [u.speed, slope.speed].map(f64::to_bits);
        if course(&input, &slope) != course(&self.input(), self.input_slope()) {
            self.stable.admit(&self.bicycle, input.speed)?;
        }
        self.settle();
        self.ramp = Ramp {
            value: input,
            slope,
            since: self.instant(),
        };
        Ok(())
    }

    /// The copy becomes the state: something changes at this instant.
    fn settle(&mut self) {
        if self.ahead {
            self.base = self.here;
            self.base_on_grid = false;
            self.ahead = false;
        }
    }

    /// Refuses where a ramp of the speed leads, from here to time `to` [s], out of the range in
    /// which the internal step is stable. Cheap: a comparison or two, mostly, and nothing without
    /// such a ramp. [`Self::advance`] itself does not ask.
    pub fn check_until(&self, to: f64) -> Result<(), Refusal> {
        if self.ramp.slope.speed == 0.0 {
            return Ok(());
        }
        let end = self.ramp.at(to).speed;
        let mut stable = self.stable;
        stable.admit_between(&self.bicycle, self.input().speed, end)
    }

    /// Remembers the speed that a ramp has reached, so that the next check is a cheap one.
    pub(super) fn note_speed(&mut self) {
        // whether it is a stable one is for `check_until` to say
        let _ = self.stable.admit(&self.bicycle, self.input().speed);
    }

    /// The inputs in force, at the present time.
    pub fn input(&self) -> Input {
        self.ramp.at(self.instant())
    }

    /// The rates at which the inputs change, each row in its unit per second.
    pub fn input_slope(&self) -> &Input {
        &self.ramp.slope
    }
}
