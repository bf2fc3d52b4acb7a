/// Solves `a` x = `b` for a symmetric positive definite matrix, given row by row (Cholesky); `None` if it is
/// not positive definite.
pub(crate) fn solve(mut a: Vec<f64>, b: &[f64]) -> Option<Vec<f64>> {
    let n = b.len();
    let mut x = b.to_vec();
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
        let known: f64 = (0..row).map(|k| a[row * n + k] * x[k]).sum();
        x[row] = (x[row] - known) / diagonal;
    }
    for row in (0..n).rev() {
        let known: f64 = (row + 1..n).map(|k| a[k * n + row] * x[k]).sum();
        x[row] = (x[row] - known) / a[row * n + row];
    }
    Some(x)
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
            let x = solve(a.clone(), &b).unwrap();
            for row in 0..n {
                let product: f64 = (0..n).map(|k| a[row * n + k] * x[k]).sum();
                assert!((product - b[row]).abs() < 1e-10, "{product} {}", b[row]);
            }
        }
    }

    #[test]
    fn what_is_not_positive_definite_has_no_solution() {
        for a in [[1.0, 2.0, 2.0, 1.0], [0.0, 0.0, 0.0, 1.0], [f64::NAN, 0.0, 0.0, 1.0]] {
            assert_eq!(solve(a.to_vec(), &[1.0, 1.0]), None);
        }
    }
}
