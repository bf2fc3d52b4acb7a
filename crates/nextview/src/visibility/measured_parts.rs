use crate::geometry::{Lattice, Pose, SegmentWalk, VoxelBlock, VoxelKey};
use crate::map::Snapshot;
use crate::sensor::Frame;
use crate::{Cancel, Cancelled};
use glam::{DVec3, IVec3};
use rayon::prelude::*;

/// The parts of voxels that hold measured surface: 64 cubes a quarter of a voxel wide, whatever later rays
/// did to the voxel.
///
/// A map states that a voxel holds surface, but a ray may still pass next to it. If whole voxels ended rays,
/// openings of one or two voxels would be closed.
///
/// Neighbouring pixels on the same surface are joined, so there are no holes where pixels are farther apart
/// than parts are wide.
#[derive(Clone, Debug)]
pub struct MeasuredParts {
    lattice: Lattice,
    block: VoxelBlock,
    /// By voxel of the block, a bit for each part: [`bit`].
    parts: Vec<u64>,
    /// The poses of the frames that contributed parts, in order.
    poses: Vec<Pose>,
}

/// Parts along each edge of a voxel.
const N: i32 = 4;

/// Maximum distance between points that join two pixels, in parts.
const SPACING: f64 = 0.9;

/// Neighbouring pixels show the same surface if their points are less than this many pixel widths apart, at
/// the distance of one of them. Flatter surfaces are hardly measured, and edges lie farther apart.
const SAME_SURFACE: f64 = 6.0;

impl MeasuredParts {
    /// Computes the parts of a snapshot's voxels that hold surface from these frames.
    ///
    /// Fails if `cancel` is set.
    pub fn new(frames: &[Frame], snapshot: &Snapshot, cancel: &Cancel) -> Result<Self, Cancelled> {
        let (lattice, block) = (snapshot.lattice(), snapshot.block());
        let nothing = || Self { lattice, block, parts: vec![0; block.n_voxels()], poses: Vec::new() };
        let add = |mut all: Self, frame: &Frame| {
            cancel.check()?;
            all.add(frame);
            Ok(all)
        };
        let join = |a: Self, b: Self| Ok(a.joined(b));
        frames.par_iter().try_fold(nothing, add).try_reduce(nothing, join)
    }

    /// Computes the parts for these frames in the voxels of a snapshot. Frames already included, with the
    /// same poses, are not read again.
    ///
    /// Fails if `cancel` is set.
    pub fn after(self, frames: &[Frame], snapshot: &Snapshot, cancel: &Cancel) -> Result<Self, Cancelled> {
        let voxels = (snapshot.lattice(), snapshot.block());
        let poses = frames.iter().map(Frame::world_from_camera);
        let n_known = self.poses.len();
        let is_part =
            (self.lattice, self.block) == voxels && poses.take(n_known).eq(self.poses.iter().copied());
        match is_part {
            true => Ok(self.joined(Self::new(&frames[n_known..], snapshot, cancel)?)),
            false => Self::new(frames, snapshot, cancel),
        }
    }

    /// Adds the parts of later frames in the same voxels.
    fn joined(mut self, later: Self) -> Self {
        self.parts.iter_mut().zip(later.parts).for_each(|(a, b)| *a |= b);
        self.poses.extend(later.poses);
        self
    }

    /// The block of voxels.
    pub fn block(&self) -> VoxelBlock {
        self.block
    }

    /// Whether surface was measured in a voxel of the block, by its index.
    pub fn is_measured(&self, voxel: usize) -> bool {
        self.parts[voxel] != 0
    }

    /// The parts of a voxel of the block, by its index: a bit each, x fastest.
    pub(super) fn of(&self, voxel: usize) -> u64 {
        self.parts[voxel]
    }

    /// Creates parts from one number for each voxel of the block.
    #[cfg(test)]
    pub(super) fn of_parts(block: VoxelBlock, parts: Vec<u64>) -> Self {
        Self { lattice: Lattice::new(0.01).unwrap(), block, parts, poses: Vec::new() }
    }

    fn add(&mut self, frame: &Frame) {
        self.poses.push(frame.world_from_camera());
        let (lattice, bounds) = (self.lattice, self.lattice.bounds(&self.block));
        let width = frame.image().width() as usize;
        let mut rows = [vec![None; width], vec![None; width]];
        for v in 0..frame.image().height() {
            rows.swap(0, 1);
            let [above, row] = &mut rows;
            row.fill(None);
            frame.row_pixels_in(v, bounds).for_each(|(u, point)| {
                row[u as usize] = Some(lattice.to_voxels(point));
            });
            self.add_row(frame, above, row);
        }
    }

    /// Adds a row of points, in voxels, joined with each other and with those of the row above.
    fn add_row(&mut self, frame: &Frame, above: &[Option<DVec3>], row: &[Option<DVec3>]) {
        let camera = self.lattice.to_voxels(frame.world_from_camera().translation());
        let pitch = SAME_SURFACE / frame.intrinsics().focal().min_element();
        for u in 0..row.len() {
            let Some(point) = row[u] else { continue };
            self.mark(point);
            let limit = pitch * point.distance(camera);
            let near = |other: Option<DVec3>| other.filter(|other| other.distance(point) < limit);
            let (left, up) = (near(u.checked_sub(1).and_then(|u| row[u])), near(above[u]));
            let corner = near(u.checked_sub(1).and_then(|u| above[u]));
            match (left, up, corner) {
                (Some(left), Some(up), Some(corner)) => self.fill(point, left, up, corner),
                _ => left.into_iter().chain(up).for_each(|other| self.fill(point, other, point, other)),
            }
        }
    }

    /// Marks the parts of the surface between four points.
    fn fill(&mut self, point: DVec3, left: DVec3, up: DVec3, corner: DVec3) {
        let n_points = |length: f64| (length * N as f64 / SPACING).ceil().max(1.0);
        let across = n_points(point.distance(left).max(up.distance(corner)));
        let down = n_points(point.distance(up).max(left.distance(corner)));
        if across == 1.0 && down == 1.0 {
            return;
        }
        for i in 0..across as u32 {
            let along = i as f64 / across;
            let (low, high) = (point.lerp(left, along), up.lerp(corner, along));
            for j in 0..down as u32 {
                self.mark(low.lerp(high, j as f64 / down));
            }
        }
    }

    /// Marks the part that contains a point, in voxels.
    fn mark(&mut self, point: DVec3) {
        let part = (point * N as f64).floor().as_ivec3();
        let key = IVec3::new(part.x.div_euclid(N), part.y.div_euclid(N), part.z.div_euclid(N));
        if let Some(voxel) = self.block.index(key) {
            self.parts[voxel] |= 1 << bit(part - key * N);
        }
    }
}

/// The number of a part, by its position in the voxel.
fn bit(part: IVec3) -> i32 {
    part.x + N * (part.y + N * part.z)
}

/// Whether a ray meets one of these parts of a voxel that it crosses; `origin` and `direction` in voxels.
pub(super) fn meets(parts: u64, key: VoxelKey, origin: DVec3, direction: DVec3) -> bool {
    let first = key * N;
    let mut walk = SegmentWalk::ray_within(origin * N as f64, direction, first, first + (N - 1));
    while let Some(at) = &mut walk {
        if parts >> bit(at.key() - first) & 1 == 1 {
            return true;
        }
        if at.advance().is_none() {
            break;
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensor::synthetic::of_depth;
    use glam::{DQuat, UVec3};
    use proptest::prelude::*;

    fn block() -> VoxelBlock {
        VoxelBlock::new(IVec3::new(-6, -6, 40), UVec3::new(12, 12, 20)).unwrap()
    }

    fn snapshot(block: VoxelBlock) -> Snapshot {
        Snapshot::from_fn(Lattice::new(0.01).unwrap(), block, |_| None)
    }

    fn measured(frames: &[Frame]) -> MeasuredParts {
        MeasuredParts::new(frames, &snapshot(block()), &Cancel::default()).unwrap()
    }

    fn part_of(point: DVec3) -> Option<i32> {
        let part = (point * N as f64).floor().as_ivec3();
        (part.min_element() >= 0 && part.max_element() < N).then(|| bit(part))
    }

    proptest! {
        /// The slow twin: many points of the ray.
        #[test]
        fn a_ray_meets_the_parts_that_it_goes_through(
            drawn: u64, mask: u64, key in prop::array::uniform3(-3..3),
            through in prop::array::uniform3(0.01..0.99), direction in prop::array::uniform3(-1.0..1.0),
            still in 0_usize..6,
        ) {
            let (parts, key, mut direction) = (drawn & mask, IVec3::from_array(key), DVec3::from_array(direction));
            if still < 3 {
                direction[still] = 0.0;
            }
            prop_assume!(direction.length() > 0.01);
            let middle = key.as_dvec3() + DVec3::from_array(through);
            let origin = middle - 20.0 * direction / direction.length();
            let points = (-4000..4000).map(|i| DVec3::from_array(through) + direction.normalize() * f64::from(i) * 5e-4);
            let met: Vec<i32> = points.filter_map(part_of).filter(|bit| parts >> bit & 1 == 1).collect();
            let found = meets(parts, key, origin, direction);
            prop_assert!(met.is_empty() || found, "goes through {met:?}");
            if met.is_empty() && found {
                // Through a corner between two of the points.
                let aside = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| axis.cross(direction).normalize_or_zero() * 1e-3);
                let is_near = |by: DVec3| (-4000..4000).any(|i| {
                    let point = DVec3::from_array(through) + direction.normalize() * f64::from(i) * 5e-4 + by;
                    part_of(point).is_some_and(|bit| parts >> bit & 1 == 1)
                });
                prop_assert!(aside.into_iter().any(|by| is_near(by) || is_near(-by)));
            }
        }
    }

    /// Pixels are a centimetre apart, parts a quarter of it.
    #[test]
    fn a_wall_has_no_holes() {
        for slope in [0.0, 0.4, 2.0] {
            let wall = measured(&[of_depth(21, 17, |u, _| 0.5 + slope * 0.005 * (u as f32 - 10.0))]);
            for i in 0..40 * 40 {
                let aim = DVec3::new(f64::from(i % 40) * 0.2 - 4.0, f64::from(i / 40) * 0.2 - 4.0, 50.0);
                let hits = (0..block().n_voxels()).any(|voxel| {
                    wall.is_measured(voxel) && meets(wall.of(voxel), block().key(voxel), DVec3::ZERO, aim)
                });
                assert!(hits, "slope {slope}: a ray to {aim} goes through");
            }
        }
    }

    #[test]
    fn edges_are_not_joined() {
        let step = measured(&[of_depth(21, 17, |u, _| if u < 10 { 0.45 } else { 0.55 })]);
        let middle = (47..53).flat_map(|z| (-6..6).map(move |x| IVec3::new(x, 0, z)));
        for key in middle {
            assert!(!step.is_measured(block().index(key).unwrap()), "{key}");
        }
    }

    #[test]
    fn frames_add_up_and_none_is_nothing() {
        let (left, right) =
            (of_depth(21, 17, |u, _| if u < 10 { 0.5 } else { 9.0 }), of_depth(21, 17, |_, _| 0.45));
        let both = measured(&[left.clone(), right.clone()]);
        let (left, right) = (measured(&[left]), measured(&[right]));
        for voxel in 0..block().n_voxels() {
            assert_eq!(both.of(voxel), left.of(voxel) | right.of(voxel));
            assert!(!measured(&[]).is_measured(voxel));
        }
    }

    /// The slow twin: all frames from scratch.
    #[test]
    fn more_frames_other_poses_and_other_voxels_give_their_own_parts() {
        let frame = |depth: f32, x: f64| {
            let pose = Pose::new(DQuat::IDENTITY, DVec3::X * x).unwrap();
            of_depth(21, 17, move |_, _| depth).with_pose(pose)
        };
        let (a, b, moved) = (frame(0.45, 0.0), frame(0.5, 0.02), frame(0.45, 0.01));
        let other = VoxelBlock::new(IVec3::new(-4, -4, 44), UVec3::splat(8)).unwrap();
        let before = measured(std::slice::from_ref(&a));
        for (frames, block) in [
            (vec![a.clone(), b.clone()], block()),
            (vec![a.clone()], block()),
            (vec![moved, b.clone()], block()),
            (vec![b], block()),
            (vec![], block()),
            (vec![a], other),
        ] {
            let anew = MeasuredParts::new(&frames, &snapshot(block), &Cancel::default()).unwrap();
            let after = before.clone().after(&frames, &snapshot(block), &Cancel::default()).unwrap();
            assert_eq!((after.parts, after.poses, after.block), (anew.parts, anew.poses, anew.block));
        }
    }

    #[test]
    fn beyond_the_block_nothing_is_kept() {
        let away = Pose::new(DQuat::IDENTITY, DVec3::X).unwrap();
        let far = measured(&[of_depth(21, 17, |_, _| 0.5).with_pose(away)]);
        assert!((0..block().n_voxels()).all(|voxel| !far.is_measured(voxel)));
    }
}
