//! Numbers as a reader wants them: rounded to what is known, units in words.

use crate::figure::shown;
use crate::verdict::Estimate;

/// Decimals that show `size` to `digits` significant digits.
fn decimals(size: f64, digits: i32) -> usize {
    if size == 0.0 || !size.is_finite() {
        return 0;
    }
    (digits - 1 - size.abs().log10().floor() as i32).max(0) as usize
}

/// `value` with so many decimals, a real minus, and no minus before a zero.
fn fixed(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(digits) if digits.contains(|c: char| ('1'..='9').contains(&c)) => format!("−{digits}"),
        Some(digits) => digits.into(),
        None => text,
    }
}

/// `value` to `digits` significant digits.
pub(crate) fn significant(value: f64, digits: i32) -> String {
    fixed(value, decimals(value, digits))
}

/// `value` to two digits of its `error`.
pub(super) fn supported(value: f64, error: f64) -> String {
    fixed(value, decimals(error, 2))
}

/// `value` as it was given, to eight digits.
pub(crate) fn exact(value: f64) -> String {
    let digits = format!("{value:.7e}").parse::<f64>().unwrap_or(value);
    // + 0 turns −0 into 0
    format!("{}", digits + 0.0).replace('-', "−")
}

/// A given value [SI] with its unit.
pub(crate) fn exact_with_unit(value: f64, unit: &str) -> String {
    let (factor, symbol) = shown(unit);
    join(&exact(factor * value), &symbol)
}

/// A value [SI] of a channel or row with its unit, to `digits` significant digits.
pub(crate) fn with_unit(value: f64, unit: &str, digits: i32) -> String {
    let (factor, symbol) = shown(unit);
    join(&significant(factor * value, digits), &symbol)
}

/// The same without the unit, for the first end of an interval.
pub(super) fn in_unit(value: f64, unit: &str, digits: i32) -> String {
    significant(shown(unit).0 * value, digits)
}

fn join(number: &str, unit: &str) -> String {
    match unit {
        "" | "1" => number.into(),
        "°" => format!("{number}°"),
        _ => format!("{number}\u{a0}{unit}"),
    }
}

/// The numbers of an estimate: two digits of the standard error, and as many of the rest as they
/// support; three of an estimate without one.
pub(super) struct Numbers {
    pub(super) value: String,
    pub(super) std_error: Option<String>,
    pub(super) interval: Option<String>,
    pub(super) bounds: String,
    pub(super) unit: String,
}

impl Numbers {
    pub(super) fn of(estimate: &Estimate) -> Self {
        let (factor, unit) = shown(&estimate.unit);
        let value = factor * estimate.value;
        let decimals = match estimate.std_error {
            Some(error) if error > 0.0 => decimals(factor * error, 2),
            _ => decimals(value, 3),
        };
        let number = |value: f64| fixed(factor * value, decimals);
        let pair = |(low, high): (f64, f64)| format!("{} to {}", number(low), number(high));
        let [lower, upper] = [estimate.lower, estimate.upper].map(|end| exact(factor * end));
        Self {
            value: fixed(value, decimals),
            std_error: estimate.std_error.map(number),
            interval: estimate.interval.map(pair),
            bounds: format!("{lower} to {upper}"),
            unit,
        }
    }

    /// `13.87 ± 0.15 1/rad`.
    pub(super) fn in_words(&self) -> String {
        match &self.std_error {
            Some(error) => join(&format!("{} ± {error}", self.value), &self.unit),
            None => join(&self.value, &self.unit),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verdict::Verdict;

    fn estimate(value: f64, std_error: Option<f64>, unit: &str) -> Estimate {
        Estimate {
            of: None,
            name: "cornering_stiffness".into(),
            unit: unit.into(),
            value,
            std_error,
            interval: std_error.map(|s| (value - 2.0 * s, value + 2.0 * s)),
            lower: 0.0,
            upper: 40.0,
            at_bound: false,
            verdict: Verdict::Determined,
            trades_against: Vec::new(),
        }
    }

    #[test]
    fn the_standard_error_decides_the_digits() {
        let words = |value, error, unit| Numbers::of(&estimate(value, error, unit)).in_words();
        assert_eq!(
            words(13.86912, Some(0.1534), "1/rad"),
            "13.87 ± 0.15\u{a0}1/rad"
        );
        assert_eq!(words(13.86912, Some(23.4), "1/rad"), "14 ± 23\u{a0}1/rad");
        assert_eq!(
            words(0.0312, Some(0.00996), "N.m.s/rad"),
            "0.0312 ± 0.0100\u{a0}N\u{a0}m\u{a0}s/rad"
        );
        assert_eq!(words(0.314159, None, "N.m"), "0.314\u{a0}N\u{a0}m");
        assert_eq!(words(0.0, None, "N.m"), "0\u{a0}N\u{a0}m");
        assert_eq!(words(0.1, Some(0.01), "rad"), "5.73 ± 0.57°");
    }

    #[test]
    fn intervals_and_bounds_have_real_minuses_and_no_negative_zero() {
        let numbers = Numbers::of(&estimate(1.0, Some(2.5), "m"));
        assert_eq!(numbers.interval.as_deref(), Some("−4.0 to 6.0"));
        assert_eq!(numbers.bounds, "0 to 40");
        assert_eq!(fixed(-0.001, 2), "0.00");
        assert_eq!(exact(0.1 + 0.2), "0.3");
        assert_eq!(exact(-0.0), "0");
    }
}
