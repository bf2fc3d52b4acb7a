use crate::geometry::{Aabb, Lattice, Plane};
use crate::sensor::Frame;
use glam::IVec3;
use rustc_hash::FxHashSet;

/// Edge of the cells, in voxels. Wrong poses and noise move points into neighbouring voxels, which would
/// count as progress.
const CELL_IN_VOXELS: f64 = 2.0;

/// The cells with a measured point, and their number after each step.
#[derive(Clone, Debug)]
pub(super) struct SeenCells {
    lattice: Lattice,
    cells: FxHashSet<IVec3>,
    n_after: Vec<usize>,
}

impl SeenCells {
    /// Returns an empty set for voxels of a valid size.
    pub fn new(voxel_size: f64) -> Self {
        let lattice = Lattice::new(CELL_IN_VOXELS * voxel_size).expect("the session checked the voxel size");
        Self { lattice, cells: FxHashSet::default(), n_after: Vec::new() }
    }

    /// Adds the points of a step's frames (usually one) in the box and above the top of a table.
    pub fn add(&mut self, frames: &[Frame], bounds: Option<Aabb>, table_top: Option<Plane>) {
        let points =
            bounds.into_iter().flat_map(|bounds| frames.iter().flat_map(move |f| f.points_in(bounds)));
        let of_object = points.filter(|point| table_top.is_none_or(|top| top.height(*point) > 0.0));
        self.cells.extend(of_object.map(|point| self.lattice.key(point)));
        self.n_after.push(self.cells.len());
    }

    /// Adds the points of frames from before the first step.
    pub fn know(&mut self, frames: &[Frame], bounds: Option<Aabb>, table_top: Option<Plane>) {
        let n_after = self.n_after.clone();
        self.add(frames, bounds, table_top);
        self.n_after = n_after;
        let n_new = self.cells.len() - self.n_after.last().copied().unwrap_or(0);
        self.n_after.iter_mut().for_each(|n| *n += n_new);
    }

    /// Returns the share, 0..=1, of the cells first shown by the last `n` steps; `None` if there were no more
    /// steps than that, or nothing was shown.
    pub fn progress(&self, n: usize) -> Option<f64> {
        let (last, before) = self.n_after.split_last()?;
        let start = before[before.len().checked_sub(n)?];
        (*last > 0).then(|| (last - start) as f64 / *last as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;
    use crate::sensor::{DepthImage, Intrinsics};
    use glam::{DVec2, DVec3};

    /// A camera at x looking along z at a wall 1 m away, with pixels 1 cm apart.
    fn frame(x: f64) -> Frame {
        let optics = Intrinsics::pinhole(10, 1, DVec2::splat(100.0), DVec2::ZERO).unwrap();
        let pose = Pose::new(glam::DQuat::IDENTITY, DVec3::new(x + 0.005, 0.005, 0.0)).unwrap();
        Frame::new(DepthImage::from_metres(10, 1, vec![1.005; 10]).unwrap(), optics, pose, 2.0).unwrap()
    }

    #[test]
    fn progress_is_the_share_of_new_cells() {
        let everywhere = Some(Aabb::cube(DVec3::ZERO, 2.0));
        let mut seen = SeenCells::new(0.005);
        assert_eq!(seen.progress(1), None);
        seen.add(&[frame(0.0)], everywhere, None);
        assert_eq!(seen.progress(1), None, "one frame has nothing before it");
        seen.add(&[frame(0.06)], everywhere, None);
        assert!((seen.progress(1).unwrap() - 6.0 / 16.0).abs() < 1e-9, "{:?}", seen.progress(1));
        seen.add(&[frame(0.03)], everywhere, None);
        assert_eq!(seen.progress(1), Some(0.0));
        assert!((seen.progress(2).unwrap() - 6.0 / 16.0).abs() < 1e-9);
        seen.add(&[frame(1.0)], everywhere, Plane::horizontal(2.0).ok());
        seen.add(&[frame(1.0)], None, None);
        assert_eq!(seen.progress(2), Some(0.0), "below the table, and without a box");
    }
}
