use super::distortion::{self, polynomial};
use super::{Distortion, Intrinsics};
use crate::instructions::instructions;
use glam::{DVec2, DVec3};
use pulp::{Simd, WithSimd};

/// Points of an image or of the plane z = 1, in a layout for vector instructions. The operations, and hence
/// the bits, are the same as for single points. Loops over the points contain only arithmetic; branches come
/// afterwards.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Points<const N: usize> {
    pub x: [f64; N],
    pub y: [f64; N],
    /// Whether the lens model has an answer; other values are meaningless.
    pub is_known: [bool; N],
}

impl Intrinsics {
    /// Applies [`deproject`](Self::deproject) to all pixels of an image row, from left to right.
    pub(crate) fn deproject_row(&self, v: u32) -> Vec<Option<DVec2>> {
        instructions().dispatch(DeprojectRow { intrinsics: self, v })
    }

    /// Applies [`deproject`](Self::deproject) to several pixels. Must be inlined where vector instructions
    /// are enabled.
    #[inline(always)]
    pub(crate) fn deproject_lanes<const N: usize>(&self, mut pixels: Points<N>) -> Points<N> {
        let (center, focal) = (self.center(), self.focal());
        for i in 0..N {
            pixels.x[i] = (pixels.x[i] - center.x) / focal.x;
            pixels.y[i] = (pixels.y[i] - center.y) / focal.y;
        }
        match self.distortion() {
            Distortion::None => pixels,
            Distortion::BrownConrady(k) => invert(&k, pixels),
            Distortion::InverseBrownConrady(k) => unfolded(&k, pixels),
        }
    }

    /// Applies [`project`](Self::project) to several points, which is faster than one at a time.
    pub fn project_lanes<const N: usize>(&self, points: &[DVec3; N]) -> [Option<DVec2>; N] {
        let mut ideal = Points { x: [0.0; N], y: [0.0; N], is_known: [false; N] };
        for (i, point) in points.iter().enumerate().filter(|(_, point)| point.z > 0.0) {
            (ideal.x[i], ideal.y[i], ideal.is_known[i]) = (point.x / point.z, point.y / point.z, true);
        }
        let observed = match self.distortion() {
            Distortion::None => ideal,
            Distortion::BrownConrady(k) => unfolded(&k, ideal),
            Distortion::InverseBrownConrady(k) => instructions().dispatch(Invert { k: &k, targets: ideal }),
        };
        std::array::from_fn(|i| {
            let point = observed.is_known[i].then(|| DVec2::new(observed.x[i], observed.y[i]))?;
            Some(point * self.focal() + self.center())
        })
    }
}

struct DeprojectRow<'a> {
    intrinsics: &'a Intrinsics,
    v: u32,
}

impl WithSimd for DeprojectRow<'_> {
    type Output = Vec<Option<DVec2>>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Vec<Option<DVec2>> {
        const N: usize = 8;
        let width = self.intrinsics.width();
        let mut row = Vec::with_capacity(width as usize + N);
        for first in (0..width).step_by(N) {
            let x = std::array::from_fn(|i| (first + i as u32) as f64);
            let pixels = Points { x, y: [self.v as f64; N], is_known: [true; N] };
            let ideal = self.intrinsics.deproject_lanes(pixels);
            for i in 0..N {
                row.push(ideal.is_known[i].then(|| DVec2::new(ideal.x[i], ideal.y[i])));
            }
        }
        row.truncate(width as usize);
        row
    }
}

struct Invert<'a, const N: usize> {
    k: &'a [f64; 5],
    targets: Points<N>,
}

impl<const N: usize> WithSimd for Invert<'_, N> {
    type Output = Points<N>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Points<N> {
        invert(self.k, self.targets)
    }
}

/// Vector form of the function of this name for one point.
#[inline(always)]
fn unfolded<const N: usize>(k: &[f64; 5], mut points: Points<N>) -> Points<N> {
    let (mut determinants, mut slopes) = ([0.0; N], [0.0; N]);
    for i in 0..N {
        let (value, derivative) = polynomial(k, DVec2::new(points.x[i], points.y[i]));
        (points.x[i], points.y[i]) = (value.x, value.y);
        (determinants[i], slopes[i]) = (derivative.determinant(), derivative.x_axis.x);
    }
    for i in 0..N {
        points.is_known[i] &= determinants[i] > 0.0 && slopes[i] > 0.0;
    }
    points
}

/// Newton's method needs four or five steps; points that have not converged after this many are left to the
/// function for one point.
const MAX_STEPS: usize = 8;

/// Vector form of the function of this name for one point; converged points stay unchanged.
#[inline(always)]
fn invert<const N: usize>(k: &[f64; 5], targets: Points<N>) -> Points<N> {
    let mut points = targets;
    let mut is_done = [false; N];
    for _ in 0..MAX_STEPS {
        let (next, determinants, is_last) = newton_step(k, &points, &targets);
        for i in 0..N {
            if !is_done[i] && determinants[i] > 0.0 {
                (points.x[i], points.y[i], is_done[i]) = (next.x[i], next.y[i], is_last[i]);
            }
        }
        if is_done == [true; N] {
            break;
        }
    }
    points.is_known = unfolded(k, points).is_known;
    for i in (0..N).filter(|&i| !is_done[i]) {
        let point = distortion::invert(k, DVec2::new(targets.x[i], targets.y[i]));
        points.is_known[i] = targets.is_known[i] && point.is_some();
        (points.x[i], points.y[i]) = point.unwrap_or_default().into();
    }
    points
}

/// Returns the points after a step, the determinants before it, and whether no further step is needed.
#[inline(always)]
fn newton_step<const N: usize>(
    k: &[f64; 5],
    points: &Points<N>,
    targets: &Points<N>,
) -> (Points<N>, [f64; N], [bool; N]) {
    let mut next = *points;
    let (mut determinants, mut moved_sq, mut limits) = ([0.0; N], [0.0; N], [0.0; N]);
    for i in 0..N {
        let point = DVec2::new(points.x[i], points.y[i]);
        let (value, derivative) = polynomial(k, point);
        let step = derivative.inverse() * (value - DVec2::new(targets.x[i], targets.y[i]));
        let after = point - step;
        (next.x[i], next.y[i]) = (after.x, after.y);
        (determinants[i], moved_sq[i]) = (derivative.determinant(), step.length_squared());
        limits[i] = 1e-30 * (1.0 + after.length_squared());
    }
    (next, determinants, std::array::from_fn(|i| moved_sq[i] <= limits[i]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Also far outside the image, where the models have no answer.
        #[test]
        fn many_points_are_as_many_times_one(
            at in prop::array::uniform16(-3.0..3.0), scale in prop::sample::select(vec![0.1, 0.3, 1.0]),
            k in prop::array::uniform5(-0.25..0.25),
        ) {
            let pinhole = Intrinsics::pinhole(640, 480, DVec2::new(600.0, 610.0), DVec2::new(320.0, 250.0)).unwrap();
            let point = |i: usize| DVec2::new(at[i], at[i + 8]) * scale;
            for lens in [Distortion::None, Distortion::BrownConrady(k), Distortion::InverseBrownConrady(k)] {
                let camera = pinhole.with_distortion(lens).unwrap();
                let pixels: [DVec2; 8] = std::array::from_fn(|i| point(i) * camera.focal() + camera.center());
                let (x, y) = (pixels.map(|pixel| pixel.x), pixels.map(|pixel| pixel.y));
                let ideal = camera.deproject_lanes(Points { x, y, is_known: [true; 8] });
                let in_camera: [DVec3; 8] = std::array::from_fn(|i| point(i).extend(1.0) * 0.7);
                for (i, &pixel) in pixels.iter().enumerate() {
                    let found = ideal.is_known[i].then(|| DVec2::new(ideal.x[i], ideal.y[i]));
                    prop_assert_eq!(found, camera.deproject(pixel));
                }
                prop_assert_eq!(camera.project_lanes(&in_camera), in_camera.map(|point| camera.project(point)));
            }
        }
    }

    #[test]
    fn a_row_is_all_its_pixels() {
        let camera = Intrinsics::pinhole(13, 5, DVec2::splat(9.0), DVec2::new(6.0, 2.0)).unwrap();
        for lens in [Distortion::None, Distortion::BrownConrady([-0.4, 0.0, 0.01, 0.0, 0.0])] {
            let camera = camera.with_distortion(lens).unwrap();
            let pixels = (0..13).map(|u| camera.deproject(DVec2::new(u as f64, 4.0)));
            assert_eq!(camera.deproject_row(4), pixels.collect::<Vec<_>>());
        }
    }

    #[test]
    fn what_is_behind_the_camera_is_not_projected() {
        let camera = Intrinsics::d435i();
        let pixels = camera.project_lanes(&[DVec3::Z, DVec3::NEG_Z, DVec3::ZERO]);
        assert_eq!(pixels, [camera.project(DVec3::Z), None, None]);
    }
}
