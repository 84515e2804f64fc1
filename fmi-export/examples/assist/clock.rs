//! The clock of a sampled controller.

/// An instant this close to a tick, as a fraction of the period, is the tick: an importer that adds
/// up its steps drifts by far less.
const SLACK: f64 = 1e-6;

/// The ticks start, start + T, start + 2 T, … [s] that fall into [t, t + h), whatever h is: each
/// belongs to one communication step, and a step has any number of them.
pub fn ticks(start: f64, period: f64, t: f64, h: f64) -> impl Iterator<Item = f64> {
    let first_from = |instant: f64| ((instant - start) / period - SLACK).ceil().max(0.0) as u64;
    (first_from(t)..first_from(t + h)).map(move |tick| start + tick as f64 * period)
}

#[cfg(test)]
mod tests {
    use super::ticks;

    const PERIOD: f64 = 0.005;

    /// How many ticks each of `steps` steps of length `h` [s] has.
    fn counts(start: f64, h: f64, steps: usize) -> Vec<usize> {
        let mut t = start;
        (0..steps)
            .map(|_| {
                let count = ticks(start, PERIOD, t, h).count();
                t += h;
                count
            })
            .collect()
    }

    #[test]
    fn a_step_of_a_fifth_has_a_tick_every_fifth_time() {
        let fifths: Vec<_> = (0..1000).map(|i| usize::from(i % 5 == 0)).collect();
        // 100 s and 0.3 s have no exact binary form, and the sum of the steps drifts
        for start in [0.0, 0.3, 100.1] {
            assert_eq!(counts(start, 0.001, 1000), fifths, "{start} s");
        }
    }

    #[test]
    fn a_step_of_two_periods_has_two() {
        assert_eq!(counts(0.0, 0.010, 500), vec![2; 500]);
        assert_eq!(counts(0.0, 0.0125, 4), [3, 2, 3, 2]);
    }

    #[test]
    fn every_tick_comes_once_however_the_time_is_cut() {
        let cut = |h: f64, steps: usize| -> Vec<f64> {
            (0..steps)
                .flat_map(|i| ticks(0.0, PERIOD, i as f64 * h, h))
                .collect()
        };
        let whole = cut(3.0, 1);
        assert_eq!(whole.len(), 600);
        assert_eq!(cut(0.003, 1000), whole);
        assert_eq!(cut(1.0 / 60.0, 180), whole);
    }
}
