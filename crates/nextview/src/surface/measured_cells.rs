use super::tangent_plane::TangentPlanes;
use crate::geometry::{Aabb, Lattice};
use crate::sensor::{Frame, SurfaceNoise};
use crate::{Cancel, Cancelled, Error};
use glam::{DVec3, IVec3};
use rustc_hash::FxHashMap;

/// Accuracy of the measured surface in each cell of space: the expected error of the mean of its points,
/// along the normal.
///
/// Errors of different frames are independent; those of one frame are partly correlated, by the camera's
/// [`SurfaceNoise`]. Pose errors are not included.
#[derive(Clone, Debug)]
pub struct MeasuredCells {
    lattice: Lattice,
    error: SurfaceNoise,
    /// The camera position and the focal length, pixels, of each frame.
    cameras: Vec<(DVec3, f64)>,
    cells: FxHashMap<IVec3, CellSums>,
}

/// Sums over the frames.
#[derive(Clone, Debug, Default)]
struct CellSums {
    /// Number of points.
    n: f64,
    /// Sum over the frames of the squared number of points times the variance of their mean.
    weighted: f64,
    normal: DVec3,
    looks: Vec<CellLook>,
}

/// The points of a frame in a cell.
#[derive(Clone, Copy, Debug)]
struct CellLook {
    frame: usize,
    /// Number of points.
    n: f64,
    /// Sum of their depths.
    depth: f64,
}

/// Sums over the points of a cell in one frame.
#[derive(Clone, Copy, Default)]
struct PointSums {
    n: f64,
    variance: f64,
    depth: f64,
    normal: DVec3,
}

/// Steeper slopes than this cosine count as this one: few pixels show them, and noise alone gives single
/// points such normals, or even ones facing away from the camera.
const LEAST_COSINE: f64 = 0.7;

/// Number of image rows between two checks for cancellation.
const ROWS: u32 = 64;

impl MeasuredCells {
    /// Returns the state before the first frame, for cubes with edges of `cell` metres (at least 0.0001).
    pub fn new(cell: f64, error: SurfaceNoise) -> Result<Self, Error> {
        error.check()?;
        Ok(Self { lattice: Lattice::new(cell)?, error, cameras: Vec::new(), cells: FxHashMap::default() })
    }

    /// Adds the points of a frame in a box (world coordinates, finite). If cancelled, nothing is added.
    pub fn add(&mut self, frame: &Frame, bounds: Aabb, cancel: &Cancel) -> Result<(), Cancelled> {
        cancel.check()?;
        let planes = TangentPlanes::new(frame);
        let (width, rotation) = (frame.image().width(), frame.world_from_camera().rotation_matrix());
        let focal = frame.intrinsics().focal().x;
        let mut looks: FxHashMap<IVec3, PointSums> = FxHashMap::default();
        for v in 0..frame.image().height() {
            if v % ROWS == 0 {
                cancel.check()?;
            }
            for (u, point) in frame.row_pixels_in(v, bounds) {
                let Some(plane) = planes.at((v * width + u) as usize) else { continue };
                let look = looks.entry(self.lattice.key(point)).or_default();
                look.n += 1.0;
                look.variance += self.error.of_pixel(plane.depth as f64, plane.cosine as f64, focal);
                look.depth += plane.depth as f64;
                look.normal += rotation * plane.normal.as_dvec3();
            }
        }
        // The order of cells does not matter: each is met once.
        let frame_idx = self.cameras.len();
        for (key, PointSums { n, variance, depth, normal }) in looks {
            let cell = self.cells.entry(key).or_default();
            cell.n += n;
            cell.weighted += n * n * self.error.of_look(variance / n, n);
            cell.normal += normal;
            cell.looks.push(CellLook { frame: frame_idx, n, depth });
        }
        self.cameras.push((frame.world_from_camera().translation(), focal));
        Ok(())
    }

    /// Returns the expected error of the mean of the points in the cell of a position, standard deviation in
    /// metres; `None` if nothing was measured there.
    pub fn error_at(&self, position: DVec3) -> Option<f64> {
        self.cells.get(&self.lattice.key(position)).map(CellSums::error)
    }

    /// Returns the expected error of the mean over several cells, each with a weight, that hold the same
    /// surface, with this normal at this position; `None` if nothing was measured in any.
    pub fn error_of(&self, cells: &[(IVec3, f64)], position: DVec3, normal: DVec3) -> Option<f64> {
        let cells = cells.iter().filter_map(|(key, weight)| Some((self.cells.get(key)?, weight)));
        let looks = cells.flat_map(|(cell, weight)| {
            cell.looks.iter().map(move |look| CellLook {
                n: weight * look.n,
                depth: weight * look.depth,
                frame: look.frame,
            })
        });
        let mut looks: Vec<CellLook> = looks.filter(|look| look.n > 0.0).collect();
        looks.sort_by_key(|look| look.frame);
        // The points of one frame in several cells are one look.
        let looks = looks.chunk_by(|a, b| a.frame == b.frame);
        let (n, sum) = looks.fold((0.0, 0.0), |(n_all, sum), parts| {
            let n: f64 = parts.iter().map(|look| look.n).sum();
            let depth: f64 = parts.iter().map(|look| look.depth).sum();
            let (camera, focal) = self.cameras[parts[0].frame];
            let cosine = normal.dot((camera - position).normalize_or_zero()).abs().max(LEAST_COSINE);
            let of_pixel = self.error.of_pixel(depth / n, cosine, focal);
            (n_all + n, sum + n * n * self.error.of_look_at(of_pixel, n, cosine))
        });
        (n > 0.0).then(|| f64::sqrt(sum) / n)
    }

    /// As [`error_at`](Self::error_at), with the mean normal, of unit length, towards the side that was seen;
    /// also `None` if normals cancel out.
    pub(crate) fn surface_at(&self, position: DVec3) -> Option<(f64, DVec3)> {
        let cell = self.cells.get(&self.lattice.key(position))?;
        Some((cell.error(), cell.normal.try_normalize()?))
    }

    pub(crate) fn lattice(&self) -> &Lattice {
        &self.lattice
    }

    /// Returns the camera's error.
    pub(crate) fn surface_error(&self) -> &SurfaceNoise {
        &self.error
    }

    /// Returns all cells with their expected errors, metres, in no fixed order.
    pub(crate) fn errors(&self) -> impl Iterator<Item = (IVec3, f64)> + '_ {
        self.cells.iter().map(|(key, cell)| (*key, cell.error()))
    }

    /// Forgets all frames.
    pub(crate) fn clear(&mut self) {
        self.cells.clear();
        self.cameras.clear();
    }
}

impl CellSums {
    fn error(&self) -> f64 {
        self.weighted.sqrt() / self.n
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensor::DepthNoise;
    use crate::sensor::synthetic::of_depth;

    fn measured(correlated_share: f64, n_frames: usize) -> MeasuredCells {
        let depth = DepthNoise { constant: 0.004, ..DepthNoise::default() };
        let error = SurfaceNoise { depth, correlated_share, ..SurfaceNoise::default() };
        let mut cells = MeasuredCells::new(0.02, error).unwrap();
        // A wall from the front, whose pixels are 1 cm wide.
        let frame = of_depth(21, 17, |_, _| 0.5);
        for _ in 0..n_frames {
            cells.add(&frame, Aabb::cube(DVec3::ZERO, 1.0), &Cancel::default()).unwrap();
        }
        cells
    }

    #[test]
    fn looks_average_what_is_not_shared() {
        let at = DVec3::new(0.03, 0.03, 0.5);
        let error = |share, n| measured(share, n).error_at(at).unwrap();
        let n_pixels = 4.0_f64;
        assert!((error(0.0, 1) - 0.004 / n_pixels.sqrt()).abs() < 2e-5, "{}", error(0.0, 1));
        assert!((error(1.0, 1) - 0.004).abs() < 4e-5, "{}", error(1.0, 1));
        for share in [0.0, 0.5, 1.0] {
            assert!((error(share, 4) - 0.5 * error(share, 1)).abs() < 1e-9);
        }
        assert_eq!(measured(0.0, 1).error_at(DVec3::ZERO), None);
    }

    #[test]
    fn normals_face_the_camera() {
        let (_, normal) = measured(0.0, 2).surface_at(DVec3::new(0.03, 0.03, 0.5)).unwrap();
        assert!(normal.distance(-DVec3::Z) < 1e-6);
    }
}
