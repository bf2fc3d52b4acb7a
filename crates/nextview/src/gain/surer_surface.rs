use super::seen_voxels::{caster, occupied_voxels};
use crate::geometry::Pose;
use crate::map::{Occupancy, Snapshot};
use crate::sensor::{Depth, DepthRange, Frame, Intrinsics, SurfaceNoise};
use crate::visibility::RayCaster;
use crate::{Cancel, Cancelled};
use glam::DVec3;
use rayon::prelude::*;

/// The expected increase, in voxels, of surface known to a tolerance after another look. Over the occupied
/// voxels that a view shows, it sums the probability that the error of their surface is below the tolerance
/// after the look, less that before.
///
/// The information on a voxel's surface is the inverse of its variance, and looks add up. Cameras close to
/// each other share errors of calibration and pose. A look therefore counts by the distance between its
/// direction and the nearest one before it, seen from the voxel: fully from 10 degrees on, and proportionally
/// less below.
///
/// Rays are two voxels apart: of a surface seen straight on, every fourth voxel is counted.
#[derive(Debug)]
pub struct SurerSurface<'a> {
    snapshot: &'a Snapshot,
    caster: RayCaster<'a>,
    error: SurfaceNoise,
    /// Focal length, pixels.
    focal: f64,
    /// Metres.
    tolerance: f64,
    /// By voxel of the block.
    known: Vec<Looks>,
}

/// Distance between the directions of two looks with independent errors: 10 degrees.
const APART: f64 = 0.1743;

/// Maximum distance in depth of a voxel's surface from its middle, in standard deviations, plus a voxel.
const SPREAD: f64 = 3.0;

/// Square metres: a camera without any error counts as one with an error of a nanometre.
const LEAST_VARIANCE: f64 = 1e-18;

/// The looks at a voxel.
#[derive(Clone, Debug, Default)]
struct Looks {
    /// Unit vectors to the cameras.
    directions: Vec<DVec3>,
    /// Inverse variance of the surface, 1/m^2.
    information: f64,
}

impl<'a> SurerSurface<'a> {
    /// Creates the gain after these frames, for a camera with this error, these optics and depths. The
    /// tolerance is in metres, positive.
    ///
    /// Fails if `cancel` is set.
    pub fn new(
        snapshot: &'a Snapshot,
        intrinsics: &Intrinsics,
        depth_range: DepthRange,
        frames: &[Frame],
        error: SurfaceNoise,
        tolerance: f64,
        cancel: &Cancel,
    ) -> Result<Self, Cancelled> {
        let caster = caster(snapshot, intrinsics, depth_range);
        let focal = intrinsics.focal().x;
        let mut gain = Self { snapshot, caster, error, focal, tolerance, known: Vec::new() };
        let cameras: Vec<(Pose, &Frame)> =
            frames.iter().map(|frame| (frame.world_from_camera().inverse(), frame)).collect();
        let of_voxel = |(voxel, state): (usize, &Occupancy)| match state {
            Occupancy::Occupied => cancel.check().map(|()| gain.looks(gain.center(voxel), &cameras)),
            _ => Ok(Looks::default()),
        };
        gain.known =
            snapshot.occupancy().par_iter().enumerate().map(of_voxel).collect::<Result<_, Cancelled>>()?;
        Ok(gain)
    }

    /// Returns the expected number of seen voxels whose surface is not within the tolerance: an upper bound
    /// on the gain of any number of views.
    pub fn unsure(&self) -> f64 {
        let is_seen = |looks: &&Looks| !looks.directions.is_empty();
        self.known.iter().filter(is_seen).map(|looks| 1.0 - self.share(looks.information)).sum()
    }

    /// Returns the gain of a view, in voxels.
    pub fn gain(&self, world_from_camera: &Pose) -> f64 {
        let from_world = world_from_camera.inverse();
        let of_voxel = |voxel: u32| {
            let (looks, center) = (&self.known[voxel as usize], self.center(voxel as usize));
            if looks.directions.is_empty() {
                return 0.0;
            }
            let direction = (world_from_camera.translation() - center).normalize_or_zero();
            let look = self.information(from_world.transform_point(center).z) * looks.apart(direction);
            self.share(looks.information + look) - self.share(looks.information)
        };
        occupied_voxels(&self.caster, world_from_camera).into_iter().map(of_voxel).sum()
    }

    /// The looks of these cameras (`camera_from_world`) at a voxel's surface.
    fn looks(&self, center: DVec3, cameras: &[(Pose, &Frame)]) -> Looks {
        let mut looks = Looks::default();
        for (from_world, frame) in cameras {
            let in_camera = from_world.transform_point(center);
            let sigma = self.error.of_pixel(in_camera.z, 1.0, self.focal).sqrt();
            let spread = self.snapshot.lattice().voxel_size() + SPREAD * sigma;
            let pixel = frame.pixel_at(in_camera);
            if matches!(pixel, Some(Depth::Surface(at)) if (at as f64 - in_camera.z).abs() <= spread) {
                let direction = (frame.world_from_camera().translation() - center).normalize_or_zero();
                looks.information += self.information(in_camera.z) * looks.apart(direction);
                looks.directions.push(direction);
            }
        }
        looks
    }

    fn center(&self, voxel: usize) -> DVec3 {
        self.snapshot.lattice().center(self.snapshot.block().key(voxel))
    }

    /// Inverse variance of a look from this depth, 1/m^2: that of the mean of the pixels that show the voxel.
    fn information(&self, depth: f64) -> f64 {
        let n = (self.snapshot.lattice().voxel_size() * self.focal / depth).powi(2);
        1.0 / self.error.of_look(self.error.of_pixel(depth, 1.0, self.focal), n).max(LEAST_VARIANCE)
    }

    /// The probability that the error is within the tolerance.
    fn share(&self, information: f64) -> f64 {
        libm::erf(self.tolerance * (0.5 * information).sqrt())
    }
}

impl Looks {
    /// Independent share, 0..=1, of a look from this direction.
    fn apart(&self, direction: DVec3) -> f64 {
        let distances = self.directions.iter().map(|other| other.distance(direction));
        distances.fold(APART, f64::min) / APART
    }
}

#[cfg(test)]
mod tests {
    use super::super::plate::{VOXEL, beside, frame, met, plate};
    use super::*;

    const TOLERANCE: f64 = 0.25 * VOXEL;

    /// An error of some millimetres at 0.4 m.
    fn error() -> SurfaceNoise {
        let mut error = SurfaceNoise::of_unknown_camera();
        error.depth.quadratic = 0.01;
        error
    }

    fn gain<'a>(snapshot: &'a Snapshot, taken: &[f64], error: SurfaceNoise) -> SurerSurface<'a> {
        let frames: Vec<Frame> = taken.iter().map(|&degrees| frame(beside(degrees))).collect();
        let (camera, range, never) = (Intrinsics::d435i(), DepthRange::default(), Cancel::default());
        SurerSurface::new(snapshot, &camera, range, &frames, error, TOLERANCE, &never).unwrap()
    }

    /// The slow twin: the gain of these voxels of the plate, all of which every camera in front of it shows.
    fn by_definition(taken: &[f64], view: f64, centers: &[DVec3]) -> f64 {
        let focal = Intrinsics::d435i().focal().x;
        // By Simpson's rule over the normal distribution.
        let within = |sigma: f64| {
            let density = |x: f64| (-0.5 * x * x).exp() / std::f64::consts::TAU.sqrt();
            let (n, end) = (2000, TOLERANCE / sigma);
            let weight = |i: i32| if i == 0 || i == n { 1.0 } else { [2.0, 4.0][i as usize % 2] };
            let sum: f64 = (0..=n).map(|i| weight(i) * density(f64::from(i) / f64::from(n) * end)).sum();
            2.0 * sum * end / f64::from(n) / 3.0
        };
        let share_after = |looks: &[f64], center: DVec3| {
            let mut information = 0.0;
            for (i, &degrees) in looks.iter().enumerate() {
                let to_camera = |degrees: f64| beside(degrees).translation() - center;
                let degrees_to =
                    |other: &f64| to_camera(degrees).angle_between(to_camera(*other)).to_degrees();
                let apart = looks[..i].iter().map(degrees_to).fold(10.0, f64::min) / 10.0;
                let depth = beside(degrees).inverse().transform_point(center).z;
                let of_pixel = (0.001 + 0.01 * depth * depth).powi(2);
                let n = (VOXEL * focal / depth).powi(2);
                information += apart / (of_pixel * (0.8 + 0.2 / n));
            }
            within(information.sqrt().recip())
        };
        let after = [taken, &[view]].concat();
        centers.iter().map(|&center| share_after(&after, center) - share_after(taken, center)).sum()
    }

    #[test]
    fn is_the_rise_of_the_probability_that_the_error_is_small() {
        let snapshot = plate();
        for taken in [vec![0.0], vec![0.0, 4.0], vec![-40.0, 0.0, 30.0]] {
            let gain = gain(&snapshot, &taken, error());
            for view in [-50.0, -8.0, 1.0, 20.0, 45.0] {
                let expected = by_definition(&taken, view, &met(&snapshot, view));
                let found = gain.gain(&beside(view));
                // An angle is not quite its chord.
                assert!((found - expected).abs() <= 0.01 * expected, "{taken:?}, {view}: {found} {expected}");
            }
        }
    }

    #[test]
    fn where_all_is_sure_or_nothing_was_seen_there_is_no_gain() {
        let snapshot = plate();
        let exact = gain(&snapshot, &[0.0, 0.0, 20.0], SurfaceNoise::default());
        assert_eq!((exact.unsure(), exact.gain(&beside(40.0))), (0.0, 0.0));
        let blind = gain(&snapshot, &[], error());
        assert_eq!((blind.unsure(), blind.gain(&beside(40.0))), (0.0, 0.0));
        let once = gain(&snapshot, &[0.0], error());
        assert!(once.gain(&beside(5.0)) < once.gain(&beside(15.0)));
        assert!(gain(&snapshot, &[0.0, 40.0], error()).unsure() < once.unsure());
    }
}
