use crate::Error;
use crate::checked::checked_when_read;
use glam::{DMat2, DVec2};
use serde::{Deserialize, Serialize};

/// Lens distortion relative to the ideal pinhole, with coefficients `k1, k2, p1, p2, k3` in the order of
/// OpenCV and librealsense.
///
/// Both models use one polynomial D on the image plane at z = 1 (Brown 1966; Conrady 1919), with
/// `r2 = x^2 + y^2`:
///
/// ```text
/// x_d = x (1 + k1 r2 + k2 r2^2 + k3 r2^3) + 2 p1 x y + p2 (r2 + 2 x^2)
/// y_d = y (1 + k1 r2 + k2 r2^2 + k3 r2^3) + 2 p2 x y + p1 (r2 + 2 y^2)
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case", deny_unknown_fields, remote = "Self")]
pub enum Distortion {
    /// An ideal pinhole.
    #[default]
    None,
    /// D maps ideal to observed coordinates (OpenCV).
    BrownConrady([f64; 5]),
    /// D maps observed to ideal coordinates (librealsense, colour cameras of the D400 family).
    InverseBrownConrady([f64; 5]),
}

checked_when_read!(Distortion);

impl Distortion {
    /// Fails unless all coefficients are finite.
    pub fn check(&self) -> Result<(), Error> {
        if self.coefficients().iter().all(|k| k.is_finite()) {
            return Ok(());
        }
        Err(Error::invalid("distortion", format!("{self:?}"), "finite coefficients"))
    }

    /// Maps an ideal point of the plane z = 1 to its distorted position; `None` if the model has no answer
    /// (far outside the image, where the polynomial folds over).
    pub fn distort(&self, ideal: DVec2) -> Option<DVec2> {
        match self {
            Self::None => Some(ideal),
            Self::BrownConrady(k) => unfolded(k, ideal),
            Self::InverseBrownConrady(k) => invert(k, ideal),
        }
    }

    /// Inverts [`distort`](Self::distort).
    pub fn undistort(&self, observed: DVec2) -> Option<DVec2> {
        match self {
            Self::None => Some(observed),
            Self::BrownConrady(k) => invert(k, observed),
            Self::InverseBrownConrady(k) => unfolded(k, observed),
        }
    }

    /// Returns the maximum stretch by the lens: the largest ratio of the distance between two images to that
    /// between the ideal points, both within `radius` of the optical axis at z = 1. `None` if the polynomial
    /// folds within that radius.
    ///
    /// D's derivative is symmetric. Without the tangential terms, its eigenvalues are the radial polynomial
    /// and the derivative of r times that.
    pub(super) fn stretch(&self, radius: f64) -> Option<f64> {
        let [k1, k2, p1, p2, k3] = self.coefficients();
        let tangential = (p1.hypot(p2)) * (2.0 + 40.0_f64.sqrt()) * radius;
        let s = radius * radius;
        let (low_across, high_across) = range_of_cubic([1.0, k1, k2, k3], s);
        let (low_along, high_along) = range_of_cubic([1.0, 3.0 * k1, 5.0 * k2, 7.0 * k3], s);
        let low = low_across.min(low_along) - tangential;
        let high = high_across.max(high_along) + tangential;
        (low > 0.0).then_some(match self {
            Self::None => 1.0,
            Self::BrownConrady(_) => high,
            Self::InverseBrownConrady(_) => 1.0 / low,
        })
    }

    /// Returns the coefficients `k1, k2, p1, p2, k3`, all zero for the ideal pinhole.
    pub fn coefficients(&self) -> [f64; 5] {
        match *self {
            Self::None => [0.0; 5],
            Self::BrownConrady(k) | Self::InverseBrownConrady(k) => k,
        }
    }
}

/// Returns the polynomial D and its derivative.
#[inline(always)]
pub(super) fn polynomial(k: &[f64; 5], p: DVec2) -> (DVec2, DMat2) {
    let [k1, k2, p1, p2, k3] = *k;
    let DVec2 { x, y } = p;
    let r2 = p.length_squared();
    let radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
    let slope = 2.0 * (k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3)); // d radial / d r2, times 2
    let value = p * radial
        + DVec2::new(2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x), 2.0 * p2 * x * y + p1 * (r2 + 2.0 * y * y));
    let mixed = slope * x * y + 2.0 * p1 * x + 2.0 * p2 * y;
    let derivative = DMat2::from_cols(
        DVec2::new(radial + slope * x * x + 2.0 * p1 * y + 6.0 * p2 * x, mixed),
        DVec2::new(mixed, radial + slope * y * y + 6.0 * p1 * y + 2.0 * p2 * x),
    );
    (value, derivative)
}

/// Returns the smallest and the largest value of `c[0] + c[1] s + c[2] s^2 + c[3] s^3` in 0..=`end`.
fn range_of_cubic(c: [f64; 4], end: f64) -> (f64, f64) {
    let value = |s: f64| c[0] + s * (c[1] + s * (c[2] + s * c[3]));
    // The slope is zero at the roots of c[1] + 2 c[2] s + 3 c[3] s^2.
    let (a, b) = (3.0 * c[3], 2.0 * c[2]);
    let root = (b * b - 4.0 * a * c[1]).sqrt();
    let q = -0.5 * (b + root.copysign(b));
    let turns = [q / a, c[1] / q].into_iter().filter(|s| *s > 0.0 && *s < end).map(value);
    turns.fold((value(0.0).min(value(end)), value(0.0).max(value(end))), |(low, high), v| {
        (low.min(v), high.max(v))
    })
}

/// Returns D where it preserves orientation; beyond its fold, a second point would have the same image.
fn unfolded(k: &[f64; 5], p: DVec2) -> Option<DVec2> {
    let (value, derivative) = polynomial(k, p);
    (derivative.determinant() > 0.0 && derivative.x_axis.x > 0.0).then_some(value)
}

/// Solves D(p) = target by Newton's method from the target itself; `None` if it does not converge to a point
/// on the unfolded side.
pub(super) fn invert(k: &[f64; 5], target: DVec2) -> Option<DVec2> {
    let mut p = target;
    for _ in 0..30 {
        let (value, derivative) = polynomial(k, p);
        let residual = value - target;
        if derivative.determinant() <= 0.0 {
            return None;
        }
        let step = derivative.inverse() * residual;
        p -= step;
        if step.length_squared() <= 1e-30 * (1.0 + p.length_squared()) {
            return unfolded(k, p).map(|_| p);
        }
        if !p.is_finite() {
            return None;
        }
    }
    // Newton may end in a cycle of the last bits; the result is accepted if it solves the equation up to
    // rounding.
    let (value, _) = polynomial(k, p);
    (value.distance(target) < 1e-13).then_some(p)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_derivative_matches_differences(x in -0.8..0.8, y in -0.6..0.6, k in prop::array::uniform5(-0.2..0.2)) {
            let (p, h) = (DVec2::new(x, y), 1e-6);
            let (_, derivative) = polynomial(&k, p);
            let dx = (polynomial(&k, p + DVec2::X * h).0 - polynomial(&k, p - DVec2::X * h).0) / (2.0 * h);
            let dy = (polynomial(&k, p + DVec2::Y * h).0 - polynomial(&k, p - DVec2::Y * h).0) / (2.0 * h);
            prop_assert!(dx.distance(derivative.x_axis) < 1e-8 && dy.distance(derivative.y_axis) < 1e-8);
        }

        /// Over an image of 57 by 45 degrees, with stronger distortion than in depth cameras.
        #[test]
        fn distort_and_undistort_are_inverses(
            x in -0.55..0.55, y in -0.42..0.42,
            radial in prop::array::uniform3(-0.25..0.25), tangential in prop::array::uniform2(-0.02..0.02),
        ) {
            let p = DVec2::new(x, y);
            let k = [radial[0], radial[1], tangential[0], tangential[1], radial[2]];
            for model in [Distortion::None, Distortion::BrownConrady(k), Distortion::InverseBrownConrady(k)] {
                let observed = model.distort(p);
                let back = observed.and_then(|d| model.undistort(d));
                prop_assert!(observed.is_none() || back.is_some_and(|b| b.distance(p) < 1e-12), "{model:?}: {back:?}");
                let ideal = model.undistort(p);
                let back = ideal.and_then(|d| model.distort(d));
                prop_assert!(ideal.is_none() || back.is_some_and(|b| b.distance(p) < 1e-12), "{model:?}: {back:?}");
            }
            prop_assume!(unfolded(&k, p).is_some());
            prop_assert!(Distortion::BrownConrady(k).distort(p).is_some());
            prop_assert!(Distortion::InverseBrownConrady(k).undistort(p).is_some());
        }
    }

    proptest! {
        #[test]
        fn no_two_points_move_farther_apart_than_the_stretch(
            points in prop::array::uniform4(-0.55..0.55), near in prop::bool::ANY,
            radial in prop::array::uniform3(-0.4..0.4), tangential in prop::array::uniform2(-0.02..0.02),
        ) {
            let k = [radial[0], radial[1], tangential[0], tangential[1], radial[2]];
            let a = DVec2::new(points[0], points[1]);
            let b = if near { a + DVec2::new(points[2], points[3]) * 1e-3 } else { DVec2::new(points[2], points[3]) };
            for model in [Distortion::None, Distortion::BrownConrady(k), Distortion::InverseBrownConrady(k)] {
                let images = [a, b].map(|p| model.distort(p).filter(|image| image.length() <= 0.78));
                if let (Some(stretch), [Some(at), Some(bt)]) = (model.stretch(0.78), images) {
                    prop_assert!(at.distance(bt) <= stretch * a.distance(b) + 1e-12, "{model:?}");
                }
            }
        }
    }

    #[test]
    fn the_stretch_is_no_larger_than_needed() {
        assert_eq!(Distortion::None.stretch(0.7), Some(1.0));
        let pincushion = Distortion::BrownConrady([0.2, 0.0, 0.0, 0.0, 0.0]);
        assert!((pincushion.stretch(0.5).unwrap() - 1.15).abs() < 1e-12, "1 + 3 k1 r^2");
        let barrel = Distortion::BrownConrady([-0.4, 0.0, 0.0, 0.0, 0.0]);
        assert_eq!(barrel.stretch(0.5), Some(1.0), "in the middle");
        assert_eq!(barrel.stretch(1.0), None, "it folds at 0.91");
        let dip = Distortion::InverseBrownConrady([-0.6, 1.0, 0.0, 0.0, 0.0]);
        assert!((1.0 / dip.stretch(0.7).unwrap() - 0.838).abs() < 1e-9, "1 - 1.8 s + 5 s^2 is least at 0.18");
    }

    #[test]
    fn has_no_answer_beyond_the_fold() {
        let barrel = Distortion::BrownConrady([-0.4, 0.0, 0.0, 0.0, 0.0]);
        assert_eq!(barrel.distort(DVec2::new(3.0, 0.0)), None);
        assert_eq!(barrel.undistort(DVec2::new(3.0, 0.0)), None);
    }
}
