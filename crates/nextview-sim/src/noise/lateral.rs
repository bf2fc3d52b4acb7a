use std::f64::consts::SQRT_2;

/// Whole-pixel shifts: normally distributed and rounded. A shift takes one uniform number and a few
/// comparisons, since every pixel of every view candidate needs two.
pub(super) struct Shifts {
    /// P(|shift| <= k) for k = 0, 1, ..., until hardly anything is left.
    within: Vec<f64>,
}

impl Shifts {
    /// Creates shifts with this standard deviation, in pixels.
    pub fn new(sigma: f64) -> Self {
        let farthest = (4.0 * sigma).ceil() as usize;
        let within = |k: usize| if sigma > 0.0 { erf((k as f64 + 0.5) / (SQRT_2 * sigma)) } else { 1.0 };
        Self { within: (0..farthest).map(within).collect() }
    }

    /// The shift for a uniform number in 0..1.
    pub fn at(&self, unit: f64) -> i32 {
        let (sign, rank) = if unit < 0.5 { (-1, 2.0 * unit) } else { (1, 2.0 * unit - 1.0) };
        sign * self.within.iter().take_while(|&&within| rank >= within).count() as i32
    }
}

/// The error function of a positive number, within 1.5e-7 (Abramowitz & Stegun 1964, eq. 7.1.26).
fn erf(x: f64) -> f64 {
    let t = 1.0 / (1.0 + 0.327_591_1 * x);
    let polynomial = [1.061_405_429, -1.453_152_027, 1.421_413_741, -0.284_496_736, 0.254_829_592]
        .into_iter()
        .fold(0.0, |sum, coefficient| (sum + coefficient) * t);
    1.0 - polynomial * (-x * x).exp()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Half a pixel: 68.27 % stay, a shift by one is one to three sigmas, a larger one is beyond three.
    #[test]
    fn shifts_are_a_rounded_normal_distribution() {
        let n = 1_000_000;
        let shifts = Shifts::new(0.5);
        let share = |shift: i32| {
            let hits = (0..n).filter(|&i| shifts.at((i as f64 + 0.5) / n as f64) == shift).count();
            hits as f64 / n as f64
        };
        for (shift, expected) in [(0, 0.682_689), (1, 0.157_305), (-1, 0.157_305), (2, 0.001_350)] {
            assert!((share(shift) - expected).abs() < 2e-6, "{shift}: {}", share(shift));
        }
        assert_eq!(Shifts::new(0.0).at(0.999), 0);
    }
}
