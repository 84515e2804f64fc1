//! How a spectral density comes to the bins of a record.

use super::Analysis;
use nalgebra::{Complex, DMatrix};
use rustfft::FftPlanner;
use std::f64::consts::TAU;

/// Carries a spectral density to the bins: E|Y_k|² = ∫ |W_k(f)|² S(f) df, W_k(f) the response of
/// bin k, moving average and taper included, to e^{2πift}. No leakage is left out.
#[derive(Debug, Clone)]
pub struct Kernel {
    /// Frequencies [Hz] at which the density is wanted, from 0.
    pub frequencies: Vec<f64>,
    /// |W_k(f)|² + |W_k(−f)|², times df: bins × frequencies.
    even: DMatrix<f64>,
    /// |W_k(f)|² − |W_k(−f)|², times df: what the imaginary part of a cross-density meets.
    odd: DMatrix<f64>,
    /// Expected |Y_k|² of white noise of density 1 in each bin.
    pub white: Vec<f64>,
}

/// Points of the density to a bin: they resolve |W_k|² of a record of that length.
const POINTS: usize = 4;

impl Kernel {
    pub(super) fn new(analysis: &Analysis) -> Self {
        let spacing = 1.0 / (POINTS as f64 * analysis.duration());
        // 2 Hz beyond the band hold all that leaks into it
        let top = (analysis.recipe.band.1 + 2.0).min(0.5 / analysis.step);
        let frequencies: Vec<f64> = (0..=(top / spacing) as usize)
            .map(|j| j as f64 * spacing)
            .collect();
        let shape = (analysis.bins.len(), frequencies.len());
        let (mut even, mut odd) = (
            DMatrix::zeros(shape.0, shape.1),
            DMatrix::zeros(shape.0, shape.1),
        );
        let record = Record::new(analysis);
        // at f = 0 nothing is left of a constant
        for j in 1..shape.1 {
            let point = j.cast_signed();
            let (up, down) = (record.at(point), record.at(-point));
            for (b, &k) in analysis.bins.iter().enumerate() {
                let (plus, minus) = (up.power(k) * spacing, down.power(k) * spacing);
                even[(b, j)] = plus + minus;
                odd[(b, j)] = plus - minus;
            }
        }
        Self {
            frequencies,
            white: even.column_sum().iter().copied().collect(),
            even,
            odd,
        }
    }

    /// Expected |Y_k|² (rows) from even densities [unit²/Hz], one a column, on
    /// [`Self::frequencies`] (rows).
    pub fn expect_real(&self, densities: &DMatrix<f64>) -> DMatrix<f64> {
        &self.even * densities
    }

    /// Expected imaginary parts of cross-powers from odd imaginary parts of cross-densities.
    pub fn expect_imaginary(&self, densities: &DMatrix<f64>) -> DMatrix<f64> {
        &self.odd * densities
    }
}

/// W_k(f) in closed form. The moving average of e^{iωn} over samples l to h − 1 is
/// (e^{iωh} − e^{iωl})/((h − l)(e^{iω} − 1)). Inside the record h − n and l − n are constants, at
/// its ends h = N and l = 0; with v_n = w_n/(h − l), w the taper,
///
/// `W_k(ω) = Σ w_n e^{i(ω−ω_k)n} − (e^{iω(h−n)} Σ_h v_n e^{i(ω−ω_k)n} + e^{iωN} Σ_N v_n e^{−iω_k n}`
/// `         − e^{iω(l−n)} Σ_l v_n e^{i(ω−ω_k)n} − Σ_0 v_n e^{−iω_k n})/(e^{iω} − 1)`
///
/// over the samples whose window ends inside (h) and at the end (N) of the record, begins inside
/// (l) and at its start (0): five transforms on the grid of 1/[`POINTS`] bin hold all of it.
struct Record {
    samples: usize,
    before: usize,
    after: usize,
    whole: Vec<Complex<f64>>,
    ends_inside: Vec<Complex<f64>>,
    ends_last: Vec<Complex<f64>>,
    begins_inside: Vec<Complex<f64>>,
    begins_first: Vec<Complex<f64>>,
}

/// A [`Record`] met by one frequency.
struct Met<'a> {
    record: &'a Record,
    /// The frequency as a number of points of the grid.
    point: isize,
    /// What multiplies the four sums of the moving average.
    ends_inside: Complex<f64>,
    ends_last: Complex<f64>,
    begins_inside: Complex<f64>,
    begins_first: Complex<f64>,
}

impl Record {
    fn new(analysis: &Analysis) -> Self {
        let samples = analysis.samples;
        let (before, after) = super::reach(analysis.window);
        // the scale of `Analysis::transform`
        let scale = (analysis.step / samples as f64).sqrt();
        let fft = FftPlanner::new().plan_fft_inverse(POINTS * samples);
        // transforms of two real sequences at once
        let transform = |first: &dyn Fn(usize) -> f64, second: &dyn Fn(usize) -> f64| {
            let mut z: Vec<_> = (0..samples)
                .map(|n| Complex::new(first(n), second(n)) * scale)
                .collect();
            z.resize(fft.len(), Complex::default());
            fft.process(&mut z);
            let mirrored = |m: usize| z[(z.len() - m) % z.len()].conj();
            let parts = |m: usize| {
                let (sum, difference) = (z[m] + mirrored(m), z[m] - mirrored(m));
                (sum * 0.5, difference * Complex::new(0.0, -0.5))
            };
            (0..z.len()).map(parts).unzip()
        };
        let mean = |n: usize| {
            let (low, high) = (n.saturating_sub(before), (n + after + 1).min(samples));
            analysis.taper[n] / (high - low) as f64
        };
        let only = |inside: bool, n: usize| if inside { mean(n) } else { 0.0 };
        let (ends_inside, ends_last) = transform(&|n| only(n + after < samples, n), &|n| {
            only(n + after >= samples, n)
        });
        let (begins_inside, begins_first) =
            transform(&|n| only(n >= before, n), &|n| only(n < before, n));
        let (whole, _) = transform(&|n| analysis.taper[n], &|_| 0.0);
        Self {
            samples,
            before,
            after,
            whole,
            ends_inside,
            ends_last,
            begins_inside,
            begins_first,
        }
    }

    /// Met by the frequency of `point` points of the grid, not zero.
    fn at(&self, point: isize) -> Met<'_> {
        let grid = (POINTS * self.samples).cast_signed();
        let turn = |n: usize| {
            let position = (point * n.cast_signed()).rem_euclid(grid);
            Complex::from_polar(1.0, TAU * position as f64 / grid as f64)
        };
        // e^{iω} − 1 = 2i sin(ω/2) e^{iω/2}, without cancellation
        let half = 0.5 * TAU * point as f64 / grid as f64;
        let inverse = (Complex::new(0.0, 2.0 * half.sin()) * Complex::from_polar(1.0, half)).inv();
        Met {
            record: self,
            point,
            ends_inside: turn(self.after + 1) * inverse,
            ends_last: turn(self.samples) * inverse,
            begins_inside: turn(self.before).conj() * inverse,
            begins_first: inverse,
        }
    }
}

impl Met<'_> {
    /// |W_k|² of bin `k`.
    fn power(&self, k: usize) -> f64 {
        let Record {
            whole,
            ends_inside,
            ends_last,
            begins_inside,
            begins_first,
            ..
        } = self.record;
        let grid = whole.len().cast_signed();
        let bin = (POINTS * k).cast_signed();
        let moved = (self.point - bin).rem_euclid(grid).cast_unsigned();
        let still = (-bin).rem_euclid(grid).cast_unsigned();
        let response = whole[moved]
            - self.ends_inside * ends_inside[moved]
            - self.ends_last * ends_last[still]
            + self.begins_inside * begins_inside[moved]
            + self.begins_first * begins_first[still];
        response.norm_sqr()
    }
}
