/// The Cholesky factor of a symmetric positive definite matrix.
pub(crate) struct Cholesky {
    n: usize,
    /// The matrix L of A = L L^T, row by row; above the diagonal, what was there.
    lower: Vec<f64>,
}

impl Cholesky {
    /// Factors a matrix of `n` rows, given row by row; `None` if it is not positive definite.
    pub fn of(mut a: Vec<f64>, n: usize) -> Option<Self> {
        for row in 0..n {
            for column in 0..=row {
                let known: f64 = (0..column).map(|k| a[row * n + k] * a[column * n + k]).sum();
                let rest = a[row * n + column] - known;
                a[row * n + column] = if row > column { rest / a[column * n + column] } else { rest.sqrt() };
            }
            let diagonal = a[row * n + row];
            if !(diagonal > 0.0 && diagonal.is_finite()) {
                return None;
            }
        }
        Some(Self { n, lower: a })
    }

    /// Returns the solution of A x = `b`.
    pub fn solve(&self, b: &[f64]) -> Vec<f64> {
        let (n, a) = (self.n, &self.lower);
        let mut x = self.forward(b);
        for row in (0..n).rev() {
            let known: f64 = (row + 1..n).map(|k| a[k * n + row] * x[k]).sum();
            x[row] = (x[row] - known) / a[row * n + row];
        }
        x
    }

    /// Returns the variance of `b` x, with A the information of x: b A^-1 b.
    pub fn variance(&self, b: &[f64]) -> f64 {
        self.forward(b).iter().map(|x| x * x).sum()
    }

    /// Returns the solution of L x = `b`.
    fn forward(&self, b: &[f64]) -> Vec<f64> {
        let (n, a) = (self.n, &self.lower);
        let mut x = b.to_vec();
        for row in 0..n {
            let known: f64 = (0..row).map(|k| a[row * n + k] * x[k]).sum();
            x[row] = (x[row] - known) / a[row * n + row];
        }
        x
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::random::Random;

    #[test]
    fn what_it_finds_solves_the_equations() {
        let mut random = Random::new(3, 0);
        for n in [0, 1, 2, 7, 30] {
            let root: Vec<f64> = (0..n * n).map(|_| random.unit() - 0.5).collect();
            let square = |i: usize, j: usize| (0..n).map(|k| root[i * n + k] * root[j * n + k]).sum::<f64>();
            let a: Vec<f64> = (0..n * n)
                .map(|at| square(at / n, at % n) + if at / n == at % n { 0.1 } else { 0.0 })
                .collect();
            let b: Vec<f64> = (0..n).map(|_| random.unit()).collect();
            let factor = Cholesky::of(a.clone(), n).unwrap();
            let x = factor.solve(&b);
            for row in 0..n {
                let product: f64 = (0..n).map(|k| a[row * n + k] * x[k]).sum();
                assert!((product - b[row]).abs() < 1e-10, "{product} {}", b[row]);
            }
            let variance: f64 = b.iter().zip(&x).map(|(b, x)| b * x).sum();
            assert!((factor.variance(&b) - variance).abs() < 1e-10);
        }
    }

    #[test]
    fn what_is_not_positive_definite_has_no_factor() {
        for a in [[1.0, 2.0, 2.0, 1.0], [0.0, 0.0, 0.0, 1.0], [f64::NAN, 0.0, 0.0, 1.0]] {
            assert!(Cholesky::of(a.to_vec(), 2).is_none());
        }
    }
}
