//! Several rides at once: each ride's landscape over its own part of the variables, and what was
//! known before.

use super::Information;
use crate::error::Result;
use crate::solver::{Cost, Landscape, Quadratic};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// One ride among several.
#[derive(Debug, Clone)]
pub struct Member<L> {
    /// Its landscape.
    pub landscape: L,
    /// Which of the shared variables are its own, in its order.
    pub variables: Vec<usize>,
}

/// What was known of a variable before the rides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Known {
    /// Its mean.
    pub mean: f64,
    /// Its standard deviation.
    pub deviation: f64,
    /// By what the variance of an estimate exceeds that of the inverse curvature: the weight that
    /// gives mean and rides their share by their variances.
    pub factor: f64,
}

impl Known {
    /// Curvature of its cost.
    fn weight(&self) -> f64 {
        self.factor / (self.deviation * self.deviation)
    }
}

/// The rides, over variables they share and then the blocks of each.
#[derive(Debug, Clone)]
pub struct Together<L> {
    /// The rides.
    pub members: Vec<Member<L>>,
    /// What was known before of each shared variable.
    pub priors: Vec<Option<Known>>,
    /// By what the covariance of the estimates exceeds the inverse curvature.
    pub factor: f64,
}

impl<L: Landscape> Together<L> {
    /// Number of shared variables.
    pub fn shared(&self) -> usize {
        self.priors.len()
    }

    /// What was known before, as a cost.
    fn known(&self, z: &DVector<f64>) -> f64 {
        let costs = self.priors.iter().zip(z.iter()).filter_map(|(known, z)| {
            let known = known.as_ref()?;
            Some(0.5 * known.weight() * (z - known.mean).powi(2))
        });
        costs.sum()
    }

    /// Each member with its part of the variables `z`.
    fn parts(&self, z: &DVector<f64>) -> Vec<(&Member<L>, DVector<f64>)> {
        let mut at = self.shared();
        let part = |member: &Member<L>, at: usize| {
            let own = member.variables.iter().map(|&i| z[i]);
            let blocks = z.rows(at, member.landscape.blocks());
            DVector::from_vec(own.chain(blocks.iter().copied()).collect())
        };
        let parts = self.members.iter().map(|member| {
            let own = part(member, at);
            at += member.landscape.blocks();
            (member, own)
        });
        parts.collect()
    }

    /// `work` done for each member at its part of `z`, on all cores.
    pub fn each<T: Send>(
        &self,
        z: &DVector<f64>,
        work: impl Fn(&L, &DVector<f64>) -> T + Sync,
    ) -> Vec<T> {
        let parts = self.parts(z);
        if let [(member, own)] = &parts[..] {
            return vec![work(&member.landscape, own)];
        }
        let work = |(member, own): &(&Member<L>, DVector<f64>)| work(&member.landscape, own);
        parts.par_iter().map(work).collect()
    }

    /// What the rides know at `z`, from what each knows.
    pub fn information(
        &self,
        z: &DVector<f64>,
        of: impl Fn(&L, &DVector<f64>) -> Result<Information> + Sync,
    ) -> Result<Information> {
        let n = self.shared();
        let mut sum = Information {
            curvature: DMatrix::zeros(n, n),
            meat: None,
            freedom: None,
            factor: self.factor,
        };
        for (member, own) in self.members.iter().zip(self.each(z, of)) {
            let own = own?;
            add(&mut sum.curvature, &own.curvature, &member.variables);
            if let Some(meat) = &own.meat {
                let total = sum.meat.get_or_insert_with(|| DMatrix::zeros(n, n));
                add(total, meat, &member.variables);
            }
        }
        sum.curvature += self.known_curvature();
        if let Some(meat) = &mut sum.meat {
            *meat += self.known_scatter();
        }
        Ok(sum)
    }

    fn of_known(&self, of: impl Fn(&Known) -> f64) -> DMatrix<f64> {
        let priors = self.priors.iter();
        let values = priors.map(|known| known.as_ref().map_or(0.0, &of));
        DMatrix::from_diagonal(&DVector::from_iterator(self.shared(), values))
    }

    /// Curvature of what was known before.
    fn known_curvature(&self) -> DMatrix<f64> {
        self.of_known(Known::weight)
    }

    /// Covariance of its gradient.
    pub(super) fn known_scatter(&self) -> DMatrix<f64> {
        self.of_known(|known| known.factor * known.weight())
    }
}

/// Adds `part` over the variables `of` to `sum`.
fn add(sum: &mut DMatrix<f64>, part: &DMatrix<f64>, of: &[usize]) {
    for (k, &i) in of.iter().enumerate() {
        for (l, &j) in of.iter().enumerate() {
            sum[(i, j)] += part[(k, l)];
        }
    }
}

impl<L: Landscape> Landscape for Together<L> {
    fn blocks(&self) -> usize {
        self.members.iter().map(|m| m.landscape.blocks()).sum()
    }

    fn cost(&self, z: &DVector<f64>) -> f64 {
        let rides: f64 = self.each(z, L::cost).into_iter().sum();
        rides + self.known(z)
    }

    fn excess(&self, z: &DVector<f64>) -> f64 {
        self.each(z, L::excess).into_iter().sum()
    }

    /// Of each ride the points together: where rides are simulated they are one batch.
    fn costs(&self, points: &[DVector<f64>]) -> Vec<Cost> {
        let known: Vec<f64> = points.iter().map(|z| self.known(z)).collect();
        let parts: Vec<_> = points.iter().map(|z| self.parts(z)).collect();
        let of_ride = |(i, member): (usize, &Member<L>)| {
            let own: Vec<_> = parts.iter().map(|parts| parts[i].1.clone()).collect();
            member.landscape.costs(&own)
        };
        let rides: Vec<Vec<Cost>> = self.members.iter().enumerate().map(of_ride).collect();
        let sum = |(k, known): (usize, &f64)| {
            let of_rides = rides.iter().map(|costs| costs[k]);
            if of_rides.clone().any(Cost::failed) {
                return Cost::new(f64::INFINITY, || of_rides.map(Cost::excess).sum());
            }
            Cost::new(of_rides.map(Cost::value).sum::<f64>() + known, || 0.0)
        };
        known.iter().enumerate().map(sum).collect()
    }

    fn quadratic(&self, z: &DVector<f64>) -> Result<Quadratic> {
        let n = self.shared();
        let mut sum = Quadratic {
            gradient: DVector::zeros(n),
            curvature: DMatrix::zeros(n, n),
            blocks: Vec::new(),
        };
        for (member, own) in self.members.iter().zip(self.each(z, L::quadratic)) {
            let own = own?;
            add(&mut sum.curvature, &own.curvature, &member.variables);
            let spread = |own: &DVector<f64>, all: &mut DVector<f64>| {
                for (&i, value) in member.variables.iter().zip(own.iter()) {
                    all[i] += value;
                }
            };
            spread(&own.gradient, &mut sum.gradient);
            sum.blocks.extend(own.blocks.into_iter().map(|mut block| {
                let mut share = DVector::zeros(n);
                spread(&block.share, &mut share);
                let mut cross = DMatrix::zeros(block.cross.nrows(), n);
                for (k, &i) in member.variables.iter().enumerate() {
                    let mut column = cross.column_mut(i);
                    column += block.cross.column(k);
                }
                let mut curvature = DMatrix::zeros(n, n);
                add(&mut curvature, &block.own, &member.variables);
                (block.share, block.own, block.cross) = (share, curvature, cross);
                block
            }));
        }
        for (i, known) in self.priors.iter().enumerate() {
            if let Some(known) = known {
                sum.gradient[i] += known.weight() * (z[i] - known.mean);
            }
        }
        sum.curvature += self.known_curvature();
        Ok(sum)
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a failed step is a failed test")]
    use super::*;
    use crate::progress::Watch;
    use crate::solver::{Block, Limits, Search, minimise};

    /// y = slope · x + a start of its own, seen at x = 0, 1, 2: ½ Σ r², the start a block.
    #[derive(Clone)]
    struct Straight {
        y: [f64; 3],
    }

    impl Straight {
        fn residuals(&self, z: &DVector<f64>) -> DVector<f64> {
            DVector::from_fn(3, |i, _| self.y[i] - z[0] * i as f64 - z[1])
        }
    }

    impl Landscape for Straight {
        fn blocks(&self) -> usize {
            1
        }
        fn cost(&self, z: &DVector<f64>) -> f64 {
            0.5 * self.residuals(z).norm_squared()
        }
        fn quadratic(&self, z: &DVector<f64>) -> Result<Quadratic> {
            let r = self.residuals(z);
            let slope = DMatrix::from_column_slice(3, 1, &[0.0, -1.0, -2.0]);
            let start = DMatrix::from_element(3, 1, -1.0);
            let share = slope.transpose() * &r;
            Ok(Quadratic {
                gradient: share.clone(),
                curvature: slope.transpose() * &slope,
                blocks: vec![Block {
                    share,
                    own: slope.transpose() * &slope,
                    gradient: start.transpose() * &r,
                    curvature: start.transpose() * &start,
                    cross: start.transpose() * &slope,
                }],
            })
        }
    }

    fn member(y: [f64; 3], variable: usize) -> Member<Straight> {
        Member {
            landscape: Straight { y },
            variables: vec![variable],
        }
    }

    fn least(together: &Together<Straight>) -> DVector<f64> {
        let n = together.shared();
        let limits = Limits {
            lower: DVector::from_element(n, -10.0),
            upper: DVector::from_element(n, 10.0),
            reach: DVector::from_element(n, 100.0),
        };
        let start = DVector::zeros(n + together.blocks());
        let search = Search {
            limits: &limits,
            held: &[],
            tolerance: 1e-24,
            max_iterations: 100,
            watch: Watch::default(),
        };
        minimise(together, start, &search).unwrap().point
    }

    #[test]
    fn a_shared_slope_is_the_mean_and_starts_are_each_rides_own() {
        let members = vec![member([0.0, 1.0, 2.0], 0), member([5.0, 8.0, 11.0], 0)];
        let together = Together {
            members,
            priors: vec![None],
            factor: 1.0,
        };
        // slopes 1 and 3 of equal weight; through (1, 1) and (1, 8)
        let z = least(&together);
        // a search ends where it would gain less than 1e-8 of the cost
        assert!(
            (&z - DVector::from_row_slice(&[2.0, -1.0, 6.0])).amax() < 1e-6,
            "{z}"
        );
    }

    #[test]
    fn slopes_of_their_own_do_not_see_each_other() {
        let members = vec![member([0.0, 1.0, 2.0], 1), member([5.0, 8.0, 11.0], 0)];
        let together = Together {
            members,
            priors: vec![None, None],
            factor: 1.0,
        };
        let z = least(&together);
        assert!(
            (&z - DVector::from_row_slice(&[3.0, 1.0, 0.0, 5.0])).amax() < 1e-6,
            "{z}"
        );
        let curvature = together
            .quadratic(&z)
            .unwrap()
            .reduce(0.0)
            .unwrap()
            .curvature;
        // Σ (x − 1)² = 2 each, and nothing between them
        assert!((curvature - DMatrix::identity(2, 2) * 2.0).amax() < 1e-12);
    }

    #[test]
    fn many_points_cost_what_each_does() {
        let members = vec![member([0.0, 1.0, 2.0], 1), member([5.0, 8.0, 11.0], 0)];
        let together = Together {
            members,
            priors: vec![
                None,
                Some(Known {
                    mean: 4.0,
                    deviation: 2.0,
                    factor: 1.5,
                }),
            ],
            factor: 1.5,
        };
        let points = [[0.0, 1.0, 2.0, 3.0], [2.0, -1.0, 0.5, 7.0]];
        let mut points = points.map(|z| DVector::from_row_slice(&z)).to_vec();
        points.push(DVector::from_element(4, f64::NAN));
        let costs = together.costs(&points);
        for (z, cost) in points[..2].iter().zip(&costs) {
            assert!((cost.value() - together.cost(z)).abs() < 1e-12, "{z}");
        }
        assert!(costs[2].failed());
    }

    #[test]
    fn a_prior_weighs_as_so_many_rides() {
        let members = vec![member([0.0, 1.0, 2.0], 0)];
        let together = Together {
            members,
            priors: vec![Some(Known {
                mean: 4.0,
                deviation: 0.5f64.sqrt(),
                factor: 1.0,
            })],
            factor: 1.0,
        };
        // information 2 of the ride at 1, 2 of the prior at 4
        let z = least(&together);
        assert!((z[0] - 2.5).abs() < 1e-6, "{z}");
        let known = |_: &Straight, _: &DVector<f64>| {
            Ok(Information {
                curvature: DMatrix::from_element(1, 1, 2.0),
                meat: None,
                freedom: None,
                factor: 1.0,
            })
        };
        let information = together.information(&z, known).unwrap();
        assert!((information.curvature[(0, 0)] - 4.0).abs() < 1e-12);
    }
}
