//! Dahlquist's test equation as an FMU: a complete model.

use fmi_export::model_description::ModelDescription;
use fmi_export::{Experiment, Flow, Model, Value, describe};

fmi_export::variables! {
    /// ẋ = −k x, whose solution x(t + h) = x(t) exp(−k h) is exact for steps of any length.
    pub struct Dahlquist {
        k: f64 = 1.0, Parameter Tunable, unit "1/s", in [0.0, 100.0], "Rate of decay";
        x: f64 = 1.0, Output Continuous, initial Exact, "Solution";
        time: f64 = 0.0, Independent Continuous, unit "s", "Time";
    }
}

impl Model for Dahlquist {
    fn description() -> ModelDescription {
        describe("Dahlquist", "Dahlquist's test equation", &Self::rows())
    }

    fn new() -> Self {
        Self::default()
    }

    fn get(&self, reference: u32) -> Value {
        self.value(reference)
    }

    fn set(&mut self, reference: u32, value: Value) {
        self.assign(reference, value);
    }

    fn initialize(&mut self, experiment: &Experiment) -> Result<(), String> {
        self.time = experiment.start_time;
        Ok(())
    }

    fn step(&mut self, t: f64, h: f64) -> Flow {
        self.x *= (-self.k * h).exp();
        self.time = t + h;
        Flow::Continue
    }
}

fmi_export::export!(Dahlquist);

#[test]
fn the_golden_file_is_up_to_date() {
    let xml = fmi_export::xml::<Dahlquist>().expect("writable");
    expect_test::expect_file!["dahlquist.xml"].assert_eq(&xml);
}
