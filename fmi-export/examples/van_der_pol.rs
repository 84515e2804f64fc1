//! Van der Pol's oscillator as an FMU, with what a model may offer besides: derivatives of outputs
//! and directional derivatives.

use fmi_export::model_description::{DefaultExperiment, ModelDescription};
use fmi_export::{Experiment, Flow, Model, Value, describe};

fmi_export::variables! {
    /// ẋ₀ = x₁, ẋ₁ = μ (1 − x₀²) x₁ − x₀
    pub struct VanDerPol {
        mu: f64 = 1.0, Parameter Tunable, in [0.0, 3.0], "Nonlinearity μ";
        x0: f64 = 2.0, Output Continuous, initial Exact, from [x0], "Position";
        x1: f64 = 0.0, Output Continuous, initial Exact, from [x1], "Velocity";
        der_x0: f64 = 0.0, Output Continuous, derivative of x0, from [x1], "ẋ₀";
        der_x1: f64 = -2.0, Output Continuous, derivative of x1, from [x0, x1], "ẋ₁";
        time: f64 = 0.0, Independent Continuous, unit "s", "Time";
    }
}

const X0: u32 = 1;
const X1: u32 = 2;
const DER_X0: u32 = 3;

/// Internal steps are no longer than this [s].
const LONGEST_STEP: f64 = 0.01;
/// More of them in one communication step would not end in reasonable time.
const MOST_STEPS: f64 = 1e8;

impl VanDerPol {
    fn derivative(&self, [x0, x1]: [f64; 2]) -> [f64; 2] {
        [x1, self.mu * (1.0 - x0 * x0) * x1 - x0]
    }

    /// One step of the classical Runge–Kutta method.
    fn rk4(&mut self, h: f64) {
        let x = [self.x0, self.x1];
        let along = |h: f64, k: [f64; 2]| [x[0] + h * k[0], x[1] + h * k[1]];
        let k1 = self.derivative(x);
        let k2 = self.derivative(along(0.5 * h, k1));
        let k3 = self.derivative(along(0.5 * h, k2));
        let k4 = self.derivative(along(h, k3));
        let mean = |i: usize| (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]) / 6.0;
        [self.x0, self.x1] = along(h, [mean(0), mean(1)]);
    }

    fn update(&mut self) {
        [self.der_x0, self.der_x1] = self.derivative([self.x0, self.x1]);
    }
}

impl Model for VanDerPol {
    fn description() -> ModelDescription {
        let mut description = ModelDescription {
            author: Some("the wobble authors".to_owned()),
            version: Some(env!("CARGO_PKG_VERSION").to_owned()),
            copyright: Some("the wobble authors".to_owned()),
            license: Some(env!("CARGO_PKG_LICENSE").to_owned()),
            default_experiment: Some(DefaultExperiment {
                start_time: Some(0.0),
                stop_time: Some(20.0),
                tolerance: None,
                step_size: Some(LONGEST_STEP),
            }),
            ..describe("VanDerPol", "Van der Pol's oscillator", &Self::rows())
        };
        if let Some(capabilities) = &mut description.co_simulation {
            capabilities.provides_directional_derivative = true;
            capabilities.max_output_derivative_order = 1;
        }
        description
    }

    fn new() -> Self {
        Self::default()
    }

    fn get(&self, reference: u32) -> Value {
        self.value(reference)
    }

    fn set(&mut self, reference: u32, value: Value) {
        self.assign(reference, value);
        self.update();
    }

    fn initialize(&mut self, experiment: &Experiment) -> Result<(), String> {
        self.time = experiment.start_time;
        self.update();
        Ok(())
    }

    fn step(&mut self, t: f64, h: f64) -> Flow {
        let steps = (h / LONGEST_STEP).ceil();
        if steps > MOST_STEPS {
            return Flow::Refuse(format!(
                "expected at most {MOST_STEPS} steps, found {steps}"
            ));
        }
        let before = (self.x0, self.x1);
        for _ in 0..steps as u64 {
            self.rk4(h / steps);
        }
        if !(self.x0.is_finite() && self.x1.is_finite()) {
            (self.x0, self.x1) = before;
            let why = "so far out the steps are too long".to_owned();
            return Flow::Terminate { at: t, why };
        }
        self.update();
        self.time = t + h;
        Flow::Continue
    }

    fn output_rate(&self, reference: u32) -> f64 {
        let x = [self.x0, self.x1];
        let [der_x0, der_x1] = self.derivative(x);
        match reference {
            X0 => der_x0,
            X1 | DER_X0 => der_x1,
            _ => self.along([der_x0, der_x1])[1],
        }
    }

    fn directional_derivative(&self, unknown: &[u32], known: &[(u32, f64)]) -> Vec<f64> {
        let seed = |reference| {
            let of = known.iter().filter(|(known, _)| *known == reference);
            of.map(|(_, seed)| seed).sum::<f64>()
        };
        let (mu, dx) = (seed(0), [seed(X0), seed(X1)]);
        let mut dder = self.along(dx);
        dder[1] += (1.0 - self.x0 * self.x0) * self.x1 * mu;
        let derivative = |reference: &u32| match *reference {
            X0 => dx[0],
            X1 => dx[1],
            DER_X0 => dder[0],
            _ => dder[1],
        };
        unknown.iter().map(derivative).collect()
    }
}

impl VanDerPol {
    /// The derivative's own derivative along `dx`.
    fn along(&self, dx: [f64; 2]) -> [f64; 2] {
        let (x0, x1) = (self.x0, self.x1);
        let by_x0 = -2.0 * self.mu * x0 * x1 - 1.0;
        let by_x1 = self.mu * (1.0 - x0 * x0);
        [dx[1], by_x0 * dx[0] + by_x1 * dx[1]]
    }
}

fmi_export::export!(VanDerPol);

#[test]
fn the_golden_file_is_up_to_date() {
    let xml = fmi_export::xml::<VanDerPol>().expect("writable");
    expect_test::expect_file!["van_der_pol.xml"].assert_eq(&xml);
}
