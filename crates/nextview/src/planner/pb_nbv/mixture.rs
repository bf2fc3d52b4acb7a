use crate::geometry::random::Random;
use crate::{Cancel, Cancelled};
use glam::{DMat3, DVec3};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Maximum number of components of a mixture (the paper's T_max).
const MOST_COMPONENTS: usize = 10;

/// Maximum number of rounds of expectation and maximisation.
const MOST_ROUNDS: usize = 50;

/// Gain in the mean log-likelihood of a point, nats, below which a fit ends.
const LEAST_GAIN: f64 = 1e-3;

/// Added to the variances, voxels squared: half a voxel squared, so that one voxel has an extent.
const LEAST_VARIANCE: f64 = 0.25;

/// Divides points, in units of voxels, among the components of the Gaussian mixture of smallest BIC. Returns
/// the numbers of the points of each non-empty component.
///
/// Mixtures of 1 to 10 components are fitted by expectation and maximisation (Dempster, Laird & Rubin 1977)
/// from a start by k-means++ (Arthur & Vassilvitskii 2007) with a fixed seed.
pub(super) fn clusters(points: &[DVec3], cancel: &Cancel) -> Result<Vec<Vec<usize>>, Cancelled> {
    let sizes = (1..=MOST_COMPONENTS.min(points.len())).into_par_iter();
    let fits: Vec<MixtureFit> =
        sizes.map(|n| MixtureFit::new(points, n, cancel)).collect::<Result<_, Cancelled>>()?;
    let best = fits.into_iter().reduce(|best, fit| if fit.bic() < best.bic() { fit } else { best });
    let mut clusters = vec![Vec::new(); MOST_COMPONENTS];
    for point in 0..points.len() {
        let likeliest = best.as_ref().map_or(0, |fit| fit.likeliest(point));
        clusters[likeliest].push(point);
    }
    clusters.retain(|cluster| !cluster.is_empty());
    Ok(clusters)
}

/// A mixture fitted to points.
struct MixtureFit {
    components: Vec<Gaussian>,
    /// The shares of each component, point by point.
    shares: Vec<f64>,
    log_likelihood: f64,
}

/// A component of a mixture.
struct Gaussian {
    mean: DVec3,
    /// Inverse of the covariance.
    precision: DMat3,
    /// Logarithm of the component's weight times its density at the mean.
    log_peak: f64,
}

impl MixtureFit {
    fn new(points: &[DVec3], n_components: usize, cancel: &Cancel) -> Result<Self, Cancelled> {
        let shares = start(points, n_components);
        let mut fit = Self { components: Vec::new(), shares, log_likelihood: f64::NEG_INFINITY };
        for _ in 0..MOST_ROUNDS {
            cancel.check()?;
            let before = fit.log_likelihood;
            fit.components =
                (0..n_components).map(|component| fit.component(points, component, n_components)).collect();
            fit.expect(points);
            if fit.log_likelihood - before < LEAST_GAIN * points.len() as f64 {
                break;
            }
        }
        Ok(fit)
    }

    /// Maximisation: the component for its shares in the points.
    fn component(&self, points: &[DVec3], component: usize, n_components: usize) -> Gaussian {
        let shares = || self.shares.iter().skip(component).step_by(n_components).zip(points);
        let total: f64 = shares().map(|(share, _)| share).sum();
        // A component that has lost all its points has no weight.
        let n = total.max(f64::MIN_POSITIVE);
        let mean = shares().fold(DVec3::ZERO, |sum, (share, point)| sum + *point * *share) / n;
        let outer = |offset: DVec3| DMat3::from_cols(offset * offset.x, offset * offset.y, offset * offset.z);
        let spread = shares().fold(DMat3::ZERO, |sum, (share, point)| sum + outer(*point - mean) * *share);
        let covariance = spread * (1.0 / n) + DMat3::from_diagonal(DVec3::splat(LEAST_VARIANCE));
        let weight = total / points.len() as f64;
        let log_peak = weight.ln() - 0.5 * covariance.determinant().ln() - 1.5 * (2.0 * PI).ln();
        Gaussian { mean, precision: covariance.inverse(), log_peak }
    }

    /// Expectation: the shares of the components in the points, and the likelihood of all points.
    fn expect(&mut self, points: &[DVec3]) {
        self.log_likelihood = 0.0;
        for (point, shares) in points.iter().zip(self.shares.chunks_exact_mut(self.components.len())) {
            shares
                .iter_mut()
                .zip(&self.components)
                .for_each(|(share, gaussian)| *share = gaussian.log_density(*point));
            let largest = shares.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            shares.iter_mut().for_each(|share| *share = (*share - largest).exp());
            let total: f64 = shares.iter().sum();
            shares.iter_mut().for_each(|share| *share /= total);
            self.log_likelihood += largest + total.ln();
        }
    }

    /// The Bayesian information criterion, k ln n - 2 ln L. Each component has a weight, a mean and a
    /// covariance, 10 parameters, and the weights add up to 1.
    fn bic(&self) -> f64 {
        let (n_components, n_points) = (self.components.len(), self.shares.len() / self.components.len());
        (10 * n_components - 1) as f64 * (n_points as f64).ln() - 2.0 * self.log_likelihood
    }

    /// The component of largest share in a point, the first on ties.
    fn likeliest(&self, point: usize) -> usize {
        let shares = &self.shares[point * self.components.len()..][..self.components.len()];
        (1..shares.len()).fold(0, |best, other| if shares[other] > shares[best] { other } else { best })
    }
}

impl Gaussian {
    fn log_density(&self, point: DVec3) -> f64 {
        let offset = point - self.mean;
        self.log_peak - 0.5 * offset.dot(self.precision * offset)
    }
}

/// Assigns each point to the component with the nearest seed. The first seed is a random point. Each further
/// one is drawn in proportion to its squared distance from the nearest seed before.
fn start(points: &[DVec3], n_components: usize) -> Vec<f64> {
    let mut random = Random::new(0, n_components as u64);
    let (mut nearest, mut dist_sq) = (vec![0; points.len()], vec![f64::INFINITY; points.len()]);
    let mut seed = random.index(points.len());
    for component in 0..n_components {
        for (i, point) in points.iter().enumerate() {
            let to_seed = point.distance_squared(points[seed]);
            if to_seed < dist_sq[i] {
                (nearest[i], dist_sq[i]) = (component, to_seed);
            }
        }
        let mut drawn = random.unit() * dist_sq.iter().sum::<f64>();
        seed = dist_sq
            .iter()
            .position(|part| {
                drawn -= part;
                drawn < 0.0
            })
            .unwrap_or(seed);
    }
    nearest
        .into_iter()
        .flat_map(|own| (0..n_components).map(move |component| (component == own) as u8 as f64))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Blobs of this many points around these places, 3 voxels wide along x, 2 along y and 1 along z.
    fn blobs(places: &[DVec3], n: usize) -> Vec<DVec3> {
        let mut random = Random::new(5, 0);
        // Sums of uniform numbers are nearly normal.
        let mut normal = || (0..12).map(|_| random.unit()).sum::<f64>() - 6.0;
        let mut blob = |place: &DVec3| -> Vec<DVec3> {
            (0..n).map(|_| *place + DVec3::new(3.0 * normal(), 2.0 * normal(), normal())).collect()
        };
        places.iter().flat_map(&mut blob).collect()
    }

    #[test]
    fn distant_blobs_are_told_apart() {
        let places = [DVec3::ZERO, DVec3::X * 40.0, DVec3::new(10.0, 60.0, -30.0)];
        for n_blobs in 1..=3 {
            let points = blobs(&places[..n_blobs], 80);
            let mut clusters = clusters(&points, &Cancel::default()).unwrap();
            clusters.sort_unstable();
            let expected: Vec<Vec<usize>> = (0..n_blobs).map(|i| (80 * i..80 * (i + 1)).collect()).collect();
            assert_eq!(clusters, expected);
        }
    }

    /// The slow twin: densities with the inverse by cofactors, products instead of sums of logarithms.
    #[test]
    fn likelihood_is_that_of_the_definition() {
        let points = blobs(&[DVec3::ZERO, DVec3::new(9.0, 4.0, 0.0)], 12);
        let fit = MixtureFit::new(&points, 2, &Cancel::default()).unwrap();
        let likelihood =
            |point: &DVec3| fit.components.iter().map(|g| g.log_density(*point).exp()).sum::<f64>();
        let expected: f64 = points.iter().map(|point| likelihood(point).ln()).sum();
        assert!((fit.log_likelihood - expected).abs() < 1e-9 * expected.abs());
        // One more maximisation, by the shares of the last expectation.
        let shares: Vec<Vec<f64>> = fit.shares.chunks(2).map(<[f64]>::to_vec).collect();
        let again = MixtureFit { components: Vec::new(), shares: fit.shares, log_likelihood: 0.0 };
        let components: Vec<Gaussian> = (0..2).map(|k| again.component(&points, k, 2)).collect();
        for (k, gaussian) in components.iter().enumerate() {
            let n: f64 = shares.iter().map(|share| share[k]).sum();
            let mean = |axis: usize| shares.iter().zip(&points).map(|(s, p)| s[k] * p[axis]).sum::<f64>() / n;
            let c = |i: usize, j: usize| {
                let spread =
                    shares.iter().zip(&points).map(|(s, p)| s[k] * (p[i] - mean(i)) * (p[j] - mean(j)));
                spread.sum::<f64>() / n + if i == j { 0.25 } else { 0.0 }
            };
            let minor = |i: usize, j: usize| {
                let (a, b, e, f) = ((i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3);
                c(a, e) * c(b, f) - c(a, f) * c(b, e)
            };
            let det: f64 = (0..3).map(|j| c(0, j) * minor(0, j)).sum();
            for point in &points {
                let d = |i: usize| point[i] - mean(i);
                let form: f64 = (0..9).map(|ij| d(ij / 3) * minor(ij / 3, ij % 3) / det * d(ij % 3)).sum();
                let density = n / 24.0 / ((2.0 * PI).powi(3) * det).sqrt() * (-0.5 * form).exp();
                assert!((gaussian.log_density(*point).exp() / density - 1.0).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn few_points_are_few_clusters() {
        let of = |points: &[DVec3]| clusters(points, &Cancel::default()).unwrap();
        assert!(of(&[]).is_empty());
        assert_eq!(of(&[DVec3::ONE]), [[0]]);
        assert_eq!(of(&[DVec3::ONE; 3]), [[0, 1, 2]], "equal points are one cluster");
    }
}
