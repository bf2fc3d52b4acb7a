use glam::DVec2;

/// The highest power: degree 5 fits the D435i's lens to 0.1 pixels, 3 to 2.6 and 7 to 0.05.
const DEGREE: usize = 5;

const N_TERMS: usize = (DEGREE + 1) * (DEGREE + 2) / 2;

/// Coefficients of `x^i y^j` at `[j][i]`, zero where `i + j > DEGREE`.
type Coefficients = [[f64; DEGREE + 1]; DEGREE + 1];

/// A polynomial map of the square -1..1 to the plane.
pub(super) struct Polynomial {
    u: Coefficients,
    v: Coefficients,
}

impl Polynomial {
    /// Fits pairs of argument and value by least squares.
    pub fn fit(pairs: impl Iterator<Item = (DVec2, DVec2)>) -> Self {
        // The normal equations, with the right-hand sides for u and v in the last two columns.
        let mut rows = [[0.0; N_TERMS + 2]; N_TERMS];
        for (argument, value) in pairs {
            let terms = terms(argument);
            for (row, term) in rows.iter_mut().zip(terms) {
                let columns = terms.into_iter().chain([value.x, value.y]);
                row.iter_mut().zip(columns).for_each(|(sum, other)| *sum += term * other);
            }
        }
        solve(&mut rows);
        let coefficients = |column: usize| {
            let mut c = Coefficients::default();
            exponents().zip(&rows).for_each(|((i, j), row)| c[j][i] = row[column]);
            c
        };
        Self { u: coefficients(N_TERMS), v: coefficients(N_TERMS + 1) }
    }

    /// Returns the value at a point of the square.
    #[inline(always)]
    pub fn at(&self, point: DVec2) -> DVec2 {
        DVec2::new(value(&self.u, point), value(&self.v, point))
    }

    /// Returns a bound in the square: a step of length `s` along both axes changes no component by more than
    /// `s` times the bound.
    pub fn steepest(&self) -> f64 {
        self.sum(|i, j| i + j)
    }

    /// Returns a bound in the square: after a step of length `s` along both axes, no component deviates from
    /// its tangent by more than `s * s` times the bound.
    pub fn most_bent(&self) -> f64 {
        0.5 * self.sum(|i, j| (i + j) * (i + j).saturating_sub(1))
    }

    /// Bounds the larger component by the sum over all terms, since no power exceeds 1 in the square.
    fn sum(&self, weight: impl Fn(usize, usize) -> usize) -> f64 {
        let sum =
            |c: &Coefficients| exponents().map(|(i, j)| c[j][i].abs() * weight(i, j) as f64).sum::<f64>();
        sum(&self.u).max(sum(&self.v))
    }
}

/// Horner's scheme, in x for each power of y.
#[inline(always)]
fn value(coefficients: &Coefficients, point: DVec2) -> f64 {
    let mut value = 0.0;
    for j in (0..=DEGREE).rev() {
        let mut row = 0.0;
        for i in (0..=DEGREE - j).rev() {
            row = row * point.x + coefficients[j][i];
        }
        value = value * point.y + row;
    }
    value
}

fn exponents() -> impl Iterator<Item = (usize, usize)> {
    (0..=DEGREE).flat_map(|j| (0..=DEGREE - j).map(move |i| (i, j)))
}

fn terms(point: DVec2) -> [f64; N_TERMS] {
    let mut terms = [0.0; N_TERMS];
    exponents()
        .zip(&mut terms)
        .for_each(|((i, j), term)| *term = point.x.powi(i as i32) * point.y.powi(j as i32));
    terms
}

/// Gauss-Jordan elimination; the last two columns then hold the solutions. The matrix of normal equations
/// needs no pivoting. Its diagonal is raised slightly to give a solution for points on a line.
fn solve(rows: &mut [[f64; N_TERMS + 2]; N_TERMS]) {
    for k in 0..N_TERMS {
        rows[k][k] += 1e-12 * rows[0][0];
    }
    for k in 0..N_TERMS {
        let diagonal = rows[k][k];
        let pivot = rows[k].map(|value| value / diagonal);
        for row in rows.iter_mut() {
            let factor = row[k];
            row.iter_mut().zip(pivot).for_each(|(value, pivot)| *value -= factor * pivot);
        }
        rows[k] = pivot;
    }
}
