/// Eigenvalues and eigenvectors of a symmetric matrix.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Eigen<const N: usize> {
    /// Eigenvalues, in no particular order.
    pub values: [f64; N],
    /// Eigenvectors in the order of `values`, of unit length and orthogonal.
    pub vectors: [[f64; N]; N],
}

/// Maximum number of sweeps over all pairs; nothing changes after about the sixth.
const MAX_SWEEPS: usize = 30;

impl<const N: usize> Eigen<N> {
    /// Computes both by the cyclic Jacobi method (Golub & Van Loan, Matrix Computations, section 8.5):
    /// eliminates one off-diagonal element after another. `a` must be finite and symmetric.
    pub fn of(mut a: [[f64; N]; N]) -> Self {
        let mut vectors = std::array::from_fn(|i| std::array::from_fn(|j| (i == j) as u8 as f64));
        let pairs = || (0..N).flat_map(|p| (p + 1..N).map(move |q| (p, q)));
        for _ in 0..MAX_SWEEPS {
            let is_small =
                |(p, q): (usize, usize)| a[p][q].abs() <= f64::EPSILON * a[p][p].min(a[q][q]).abs();
            if pairs().all(is_small) {
                break;
            }
            pairs().for_each(|(p, q)| rotate(&mut a, &mut vectors, p, q));
        }
        Self { values: std::array::from_fn(|i| a[i][i]), vectors }
    }

    /// Returns the index of the smallest eigenvalue.
    pub fn smallest(&self) -> usize {
        (1..N).fold(0, |best, i| if self.values[i] < self.values[best] { i } else { best })
    }
}

/// Rotates the plane of axes `p` and `q` so that `a[p][q]` vanishes. Rows of `vectors` are the axes.
fn rotate<const N: usize>(a: &mut [[f64; N]; N], vectors: &mut [[f64; N]; N], p: usize, q: usize) {
    if a[p][q] == 0.0 {
        return;
    }
    let tau = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
    let tangent = tau.signum() / (tau.abs() + (1.0 + tau * tau).sqrt());
    let cosine = 1.0 / (1.0 + tangent * tangent).sqrt();
    let sine = tangent * cosine;
    let turned = |x: f64, y: f64| (cosine * x - sine * y, sine * x + cosine * y);
    for row in a.iter_mut() {
        (row[p], row[q]) = turned(row[p], row[q]);
    }
    for k in 0..N {
        (a[p][k], a[q][k]) = turned(a[p][k], a[q][k]);
        (vectors[p][k], vectors[q][k]) = turned(vectors[p][k], vectors[q][k]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn check<const N: usize>(a: [[f64; N]; N]) -> Result<(), TestCaseError> {
        let eigen = Eigen::of(a);
        for (i, (value, vector)) in eigen.values.iter().zip(&eigen.vectors).enumerate() {
            for row in 0..N {
                let product: f64 = (0..N).map(|k| a[row][k] * vector[k]).sum();
                prop_assert!((product - value * vector[row]).abs() < 1e-12, "{a:?} {eigen:?}");
            }
            for (j, other) in eigen.vectors.iter().enumerate() {
                let dot: f64 = vector.iter().zip(other).map(|(x, y)| x * y).sum();
                prop_assert!((dot - (i == j) as u8 as f64).abs() < 1e-12);
            }
        }
        let smallest = eigen.values[eigen.smallest()];
        prop_assert!(eigen.values.iter().all(|value| *value >= smallest));
        Ok(())
    }

    proptest! {
        #[test]
        fn the_matrix_stretches_each_vector_by_its_value(rows in prop::array::uniform6(prop::array::uniform6(-1.0..1.0)), rank in 0_usize..7) {
            // Sums of few outer products have zeros among their eigenvalues.
            let outer = |i: usize, j: usize| rows[..rank].iter().map(|row: &[f64; 6]| row[i] * row[j]).sum::<f64>();
            check::<6>(std::array::from_fn(|i| std::array::from_fn(|j| outer(i, j))))?;
            check::<3>(std::array::from_fn(|i| std::array::from_fn(|j| rows[i.min(j)][i.max(j)])))?;
        }
    }

    #[test]
    fn diagonal_matrices_are_left_alone() {
        let eigen = Eigen::of([[3.0, 0.0], [0.0, -1.0]]);
        assert_eq!((eigen.values, eigen.smallest()), ([3.0, -1.0], 1));
        assert_eq!(Eigen::of([[0.0; 6]; 6]).values, [0.0; 6]);
    }
}
