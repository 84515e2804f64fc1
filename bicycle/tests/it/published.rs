//! Published bicycles and numbers.

use bicycle::Parameters;
use bicycle::mass::Literature;
use serde_json::Value;

/// The text of a file of published numbers.
pub fn text(name: &str) -> String {
    let path = format!("{}/../tests/data/{name}", env!("CARGO_MANIFEST_DIR"));
    std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{path}: {e}"))
}

/// A file of published numbers.
pub fn file(name: &str) -> Value {
    serde_json::from_str(&text(name)).expect("JSON")
}

/// Meijaard et al. 2007: parameters and what follows from them.
pub fn benchmark() -> Value {
    file("meijaard2007_benchmark.json")
}

/// A bicycle by its parameters' names.
pub fn literature(value: impl Fn(&str) -> f64) -> Literature {
    Literature {
        w: value("w"),
        c: value("c"),
        lam: value("lam"),
        rR: value("rR"),
        mR: value("mR"),
        IRxx: value("IRxx"),
        IRyy: value("IRyy"),
        xB: value("xB"),
        zB: value("zB"),
        mB: value("mB"),
        IBxx: value("IBxx"),
        IBzz: value("IBzz"),
        IBxz: value("IBxz"),
        xH: value("xH"),
        zH: value("zH"),
        mH: value("mH"),
        IHxx: value("IHxx"),
        IHzz: value("IHzz"),
        IHxz: value("IHxz"),
        rF: value("rF"),
        mF: value("mF"),
        IFxx: value("IFxx"),
        IFyy: value("IFyy"),
    }
}

/// A bicycle of the literature, its friction free steering and no rider's law.
pub fn riderless(bicycle: &Literature) -> Parameters {
    let mut p = Parameters {
        viscous_friction: 0.0,
        coulomb_friction: 0.0,
        ..Parameters::default().riderless()
    };
    bicycle.write(&mut p, &[]);
    p
}

/// The benchmark bicycle.
pub fn benchmark_bicycle() -> Parameters {
    let file = benchmark();
    riderless(&literature(|name| {
        file["parameters"][name].as_f64().expect("a number")
    }))
}

/// The benchmark on tyres of one cornering stiffness [1/rad], without camber thrust or relaxation.
pub fn on_even_tyres(stiffness: f64) -> Parameters {
    Parameters {
        cornering_stiffness: stiffness,
        rear_cornering_stiffness: stiffness,
        camber_stiffness: 0.0,
        rear_camber_stiffness: 0.0,
        relaxation_length: 0.0,
        ..benchmark_bicycle()
    }
}

/// A section of a bicycle file of the program, its numbers in SI.
pub fn section(set: &str, path: &[&str]) -> impl Fn(&str) -> f64 {
    let file = format!(
        "{}/../identify/bicycles/{set}.toml",
        env!("CARGO_MANIFEST_DIR")
    );
    let text = std::fs::read_to_string(&file).unwrap_or_else(|e| panic!("{file}: {e}"));
    let whole: toml::Value = toml::from_str(&text).expect("TOML");
    let section = path.iter().fold(whole, |value, name| value[*name].clone());
    move |name| match &section[name] {
        toml::Value::Float(number) => *number,
        toml::Value::String(angle) => {
            let degrees = angle.strip_suffix(" deg").expect("degrees");
            degrees.parse::<f64>().expect("a number").to_radians()
        }
        other => panic!("{name}: {other}"),
    }
}

/// The steer-by-wire bicycle of Delft (`mechmotum/sbw_bicycle_with_model_matching`).
pub fn delft() -> Literature {
    literature(section("sbw-delft", &["bodies", "literature"]))
}

/// The nine measured bicycles of BicycleParameters by name, two with their riders.
pub fn measured() -> Vec<(String, Parameters)> {
    let file = file("measured_bicycles.json");
    let bicycles = file["bicycles"].as_object().expect("bicycles");
    let named = bicycles.iter().map(|(name, values)| {
        let bicycle = literature(|row| values[row].as_f64().expect("a number"));
        (name.clone(), riderless(&bicycle))
    });
    named.collect()
}
