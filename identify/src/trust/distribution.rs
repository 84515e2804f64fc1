//! The distributions that bands and intervals come from, all by way of the incomplete gamma
//! function. Abramowitz & Stegun 1964, 6.1.41, 6.5.29, 6.5.31.

/// ln Γ(a), a > 0: Stirling's series, after steps up to where it gives twelve digits.
fn ln_gamma(a: f64) -> f64 {
    let mut steps = 0.0;
    let mut x = a;
    while x < 12.0 {
        steps += x.ln();
        x += 1.0;
    }
    let y = 1.0 / (x * x);
    let series = (1.0 / 12.0 - y * (1.0 / 360.0 - y * (1.0 / 1260.0 - y / 1680.0))) / x;
    (x - 0.5) * x.ln() - x + 0.5 * std::f64::consts::TAU.ln() + series - steps
}

/// P(X ≤ x) of a gamma variable of shape `a` and scale 1: what Σ |Y_k|²/S_k of `a` complex
/// coefficients is.
pub fn gamma(a: f64, x: f64) -> f64 {
    if x <= 0.0 {
        return 0.0;
    }
    let front = (a * x.ln() - x - ln_gamma(a)).exp();
    if x < a + 1.0 {
        let (mut term, mut sum, mut k) = (1.0 / a, 1.0 / a, a);
        while term > 1e-17 * sum {
            k += 1.0;
            term *= x / k;
            sum += term;
        }
        return front * sum;
    }
    // the continued fraction of the other tail, by Lentz's method
    let mut b = x + 1.0 - a;
    let (mut c, mut d) = (f64::MAX, 1.0 / b);
    let mut fraction = d;
    for k in 1..1000 {
        let k = f64::from(k);
        let numerator = k * (a - k);
        b += 2.0;
        d = 1.0 / (numerator * d + b);
        c = b + numerator / c;
        fraction *= c * d;
        if (c * d - 1.0).abs() < 1e-16 {
            break;
        }
    }
    1.0 - front * fraction
}

/// The x with P(X ≤ x) = `p` of a gamma variable of shape `a` and scale 1, 0 < p < 1.
pub fn gamma_quantile(a: f64, p: f64) -> f64 {
    let (mut low, mut high) = (0.0, a + 1.0);
    while gamma(a, high) < p {
        high *= 2.0;
    }
    // halving to the last bit: called a few times a run
    loop {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            return middle;
        }
        if gamma(a, middle) < p {
            low = middle;
        } else {
            high = middle;
        }
    }
}

/// P(X > x) of χ² with `freedom` degrees.
pub fn chi_square_tail(freedom: f64, x: f64) -> f64 {
    1.0 - gamma(0.5 * freedom, 0.5 * x)
}

/// The x with P(X ≤ x) = `p` of χ² with `freedom` degrees.
pub fn chi_square_quantile(freedom: f64, p: f64) -> f64 {
    2.0 * gamma_quantile(0.5 * freedom, p)
}

/// Half width of the interval about 0 that holds a standard normal variable with `probability`.
pub fn normal_half_width(probability: f64) -> f64 {
    chi_square_quantile(1.0, probability).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_the_tables() {
        // Abramowitz & Stegun 1964, tables 26.1 and 26.8
        for (freedom, p, x) in [
            (1.0, 0.95, 3.841459),
            (1.0, 0.99, 6.634897),
            (2.0, 0.95, 5.991465),
            (10.0, 0.01, 2.558212),
            (30.0, 0.99, 50.892181),
            (100.0, 0.975, 129.561197),
        ] {
            assert!(
                (chi_square_quantile(freedom, p) - x).abs() < 1e-6,
                "χ²({freedom}), {p}"
            );
            assert!((chi_square_tail(freedom, x) - (1.0 - p)).abs() < 1e-6);
        }
        assert!((normal_half_width(0.95) - 1.959963985).abs() < 1e-9);
        assert!((normal_half_width(0.99) - 2.575829304).abs() < 1e-9);
    }

    #[test]
    fn one_coefficient_is_exponential_and_three_follow_the_sum() {
        for x in [0.01_f64, 0.5, 1.0, 3.0, 20.0] {
            assert!((gamma(1.0, x) - (1.0 - (-x).exp())).abs() < 1e-14);
            let sum = 1.0 - (-x).exp() * (1.0 + x + 0.5 * x * x);
            assert!((gamma(3.0, x) - sum).abs() < 1e-14);
        }
    }
}
