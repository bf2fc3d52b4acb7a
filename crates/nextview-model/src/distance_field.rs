use super::SurfaceMesh;
use super::frame_surface::{Evidence, FrameSurface};
use super::specks::without_specks;
use super::surface_nets::surface_nets_unless;
use glam::{DVec3, IVec3, UVec3};
use nextview::geometry::{Aabb, Lattice, Plane, Pose, VoxelBlock};
use nextview::sensor::Frame;
use nextview::{Cancel, Cancelled, Error};
use rayon::prelude::*;

/// Number of voxels of a row that are looked up in a frame at a time.
const LANES: usize = 8;

/// Bricks of voxels that are first looked up as a whole: most are all free, or all hidden.
const BRICK: UVec3 = UVec3::new(LANES as u32, 4, 4);

/// Maximum memory of a field, MB.
const MEMORY_LIMIT_MB: u64 = 4096;

/// Weight of a free ray without return, compared to 1 for a ray that ends at a surface farther away. With 1,
/// a recording with masks that are too tight kept 37 % of its surface within 2 mm.
const OPEN_WEIGHT: f32 = 0.1;

/// A truncated signed distance field: at each voxel centre of a block, the mean signed distance to the
/// surface over all frames (Curless & Levoy 1996; the projective form of Newcombe et al. 2011).
///
/// It departs from those papers in five ways. The distance is to the tangent plane at the pixel, not along
/// the ray, which is too long at slanted surfaces by a factor that differs between views. A frame's weight
/// falls with the voxel's distance behind its surface (as in Bylow et al. 2013), so that the two sides of a
/// thin part do not erase each other. Voxels far in front of the surface are not averaged but counted as
/// free, and only if the surface is also a voxel away sideways; a voxel is free if that outweighs the
/// measurements of a surface near it. If the ray to a voxel passes closer to the surface, the distance to the
/// silhouette gets a small weight, so rays that pass close by do not erode the object. Rays without return
/// count a tenth, and nothing if more frames show a surface at the voxel or in front of it: masks that are
/// slightly too tight would otherwise carve away most of the surface, which some frame shows next to its
/// silhouette.
///
/// ```
/// use glam::{DVec2, IVec3, UVec3};
/// use nextview::Cancel;
/// use nextview::geometry::{Lattice, Pose, VoxelBlock};
/// use nextview_model::DistanceField;
/// use nextview::sensor::{DepthImage, Frame, Intrinsics};
///
/// // A wall at 0.5 m, seen from the front.
/// let camera = Intrinsics::pinhole(64, 48, DVec2::splat(60.0), DVec2::new(31.5, 23.5)).unwrap();
/// let image = DepthImage::from_metres(64, 48, vec![0.5; 64 * 48]).unwrap();
/// let frame = Frame::new(image, camera, Pose::IDENTITY, 1.0).unwrap();
///
/// let block = VoxelBlock::new(IVec3::new(0, 0, 40), UVec3::new(1, 1, 20)).unwrap();
/// let mut field = DistanceField::new(Lattice::new(0.01).unwrap(), block, 0.02).unwrap();
/// field.integrate(&frame, &Cancel::default()).unwrap();
/// let found = field.distance(IVec3::new(0, 0, 49)).unwrap();
/// assert!((found - 0.005).abs() < 1e-6, "its centre is 5 mm in front of the wall");
/// assert_eq!(field.distance(IVec3::new(0, 0, 55)), None, "behind the wall nothing was measured");
/// ```
#[derive(Clone, Debug)]
pub struct DistanceField {
    lattice: Lattice,
    block: VoxelBlock,
    truncation: f64,
    cells: Vec<VoxelEvidence>,
}

/// The evidence of the frames so far about a voxel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct VoxelEvidence {
    /// Evidence from measured surfaces.
    measured: DistanceSums,
    /// Evidence from rays without return.
    open: DistanceSums,
    /// Number of frames with a ray without return at the voxel.
    n_open: u16,
    /// Number of frames with the voxel at or behind a surface.
    n_covered: u16,
}

/// Sums for a mean distance.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct DistanceSums {
    /// Weighted sum of the distances where the surface was near, metres.
    distance: f32,
    /// Sum of their weights.
    weight: f32,
    /// Number of frames that saw the voxel free; those without return count in part.
    free: f32,
}

impl DistanceField {
    /// Returns an empty field.
    ///
    /// `truncation` is the distance in metres up to which surfaces count, in front and behind. It must be at
    /// least two voxels, so that all corners of a cell crossed by the surface are within it, and should be
    /// above the depth error. Thinner parts come out too thick. Fails if the field would need more than 4096
    /// MB.
    pub fn new(lattice: Lattice, block: VoxelBlock, truncation: f64) -> Result<Self, Error> {
        if !(truncation >= 2.0 * lattice.voxel_size() && truncation.is_finite()) {
            return Err(Error::invalid("truncation", truncation, "a finite length of at least two voxels"));
        }
        // In floating point, since the size of a huge block does not fit an integer.
        let bytes = block.dims().as_dvec3().element_product() * size_of::<VoxelEvidence>() as f64;
        if bytes > MEMORY_LIMIT_MB as f64 * 1e6 {
            let what = format!("a distance field of {} voxels", block.dims());
            return Err(Error::TooLarge { what, needed_mb: (bytes / 1e6) as u64, limit_mb: MEMORY_LIMIT_MB });
        }
        Ok(Self { lattice, block, truncation, cells: vec![VoxelEvidence::default(); block.n_voxels()] })
    }

    /// Adds a frame. After cancellation, the field may hold part of the frame and is unusable.
    pub fn integrate(&mut self, frame: &Frame, cancel: &Cancel) -> Result<(), Cancelled> {
        self.integrate_above(frame, None, cancel)
    }

    /// As [`integrate`](Self::integrate), for an object on a table: measurements at or below `table_top`, in
    /// world coordinates, only show that the rays up to there are free. `None` if there is no table.
    pub fn integrate_above(
        &mut self,
        frame: &Frame,
        table_top: Option<Plane>,
        cancel: &Cancel,
    ) -> Result<(), Cancelled> {
        cancel.check()?;
        let camera_from_world = frame.world_from_camera().inverse();
        let Some(nearest) = self.nearest_depth(&camera_from_world) else { return Ok(()) };
        let margin = self.lattice.voxel_size();
        let surface = FrameSurface::new(frame, table_top, self.truncation, margin, nearest, cancel)?;
        let (rotation, translation) = (camera_from_world.rotation_matrix(), camera_from_world.translation());
        let (lattice, block) = (self.lattice, self.block);
        let in_camera = |voxel: DVec3| rotation * ((voxel + 0.5) * lattice.voxel_size()) + translation;
        let dims = block.dims();
        let (row, layer) = (dims.x as usize, (dims.x * dims.y) as usize);
        self.cells.par_chunks_mut(BRICK.z as usize * layer).enumerate().try_for_each(|(i, slab)| {
            let z = i as u32 * BRICK.z;
            for y in (0..dims.y).step_by(BRICK.y as usize) {
                cancel.check()?;
                for x in (0..dims.x).step_by(BRICK.x as usize) {
                    let first = UVec3::new(x, y, z);
                    let size = BRICK.min(dims - first);
                    let reach = (size - 1).as_dvec3() / 2.0;
                    let center = in_camera((block.min() + first.as_ivec3()).as_dvec3() + reach);
                    // Slightly larger, to allow for rounding.
                    let radius = reach.length() * lattice.voxel_size() * (1.0 + 1e-9);
                    let of_all = surface.evidence_of_ball(center, radius);
                    for (dz, dy) in (0..size.z).flat_map(|dz| (0..size.y).map(move |dy| (dz, dy))) {
                        let start = dz as usize * layer + (y + dy) as usize * row + x as usize;
                        let cells = &mut slab[start..start + size.x as usize];
                        if let Some(evidence) = of_all {
                            cells.iter_mut().for_each(|cell| cell.add(evidence));
                            continue;
                        }
                        let first = (block.min() + (first + UVec3::new(0, dy, dz)).as_ivec3()).as_dvec3();
                        // The last ones may lie beyond the block: their results are dropped.
                        let points = std::array::from_fn(|i| in_camera(first + DVec3::X * i as f64));
                        let evidence = surface.evidence::<LANES>(&points);
                        cells
                            .iter_mut()
                            .zip(evidence)
                            .for_each(|(cell, e)| e.into_iter().for_each(|e| cell.add(e)));
                    }
                }
            }
            Ok(())
        })
    }

    /// Returns the signed distance from a voxel's centre to the surface, metres, positive outside, at most
    /// the truncation distance; `None` if nothing was measured there.
    pub fn distance(&self, voxel: IVec3) -> Option<f32> {
        self.at(self.block.index(voxel)?)
    }

    /// Extracts the surface with [`surface_nets`](super::surface_nets), unless cancelled; open where nothing
    /// was measured.
    ///
    /// Specks, which noise creates near edges and inside walls, are removed: isolated parts with less than a
    /// hundredth of the largest part's area that have fewer than 100 triangles, or evidence of less than two
    /// frames from the front.
    pub fn surface(&self, cancel: &Cancel) -> Result<SurfaceMesh, Cancelled> {
        let distance = |index: usize| self.at(index).map(f64::from);
        let mesh = surface_nets_unless(&self.lattice, &self.block, distance, cancel)?;
        cancel.check()?;
        Ok(without_specks(mesh, |point| self.evidence_near(point)))
    }

    /// Returns the lattice of the voxels.
    pub fn lattice(&self) -> Lattice {
        self.lattice
    }

    /// Returns the voxels of the field.
    pub fn block(&self) -> VoxelBlock {
        self.block
    }

    /// As [`distance`](Self::distance), by the index in the block.
    fn at(&self, index: usize) -> Option<f32> {
        let DistanceSums { distance, weight, free } = self.cells[index].sums();
        if free > weight {
            return Some(self.truncation as f32);
        }
        (weight > 0.0).then(|| distance / weight)
    }

    /// Returns the sum of the weights of the measurements near a point.
    pub(super) fn evidence_near(&self, point: DVec3) -> f32 {
        self.block.index(self.lattice.key(point)).map_or(0.0, |index| self.cells[index].measured.weight)
    }

    /// Returns the smallest depth of the block in front of the camera; `None` if all of it lies behind.
    fn nearest_depth(&self, camera_from_world: &Pose) -> Option<f64> {
        let [min, max] = [self.block.min(), self.block.max()].map(|key| self.lattice.center(key));
        let depths = Aabb { min, max }.corners().map(|corner| camera_from_world.transform_point(corner).z);
        let depths = depths.into_iter();
        (depths.clone().fold(f64::MIN, f64::max) > 0.0).then(|| depths.fold(f64::MAX, f64::min).max(0.0))
    }
}

impl VoxelEvidence {
    fn add(&mut self, evidence: Evidence) {
        match evidence {
            Evidence::Free => self.measured.free += 1.0,
            Evidence::Open => {
                self.open.free += OPEN_WEIGHT;
                self.n_open = self.n_open.saturating_add(1);
            }
            Evidence::Near { distance, weight } => {
                self.measured.add(distance, weight);
                self.n_covered = self.n_covered.saturating_add(1);
            }
            Evidence::Silhouette { distance, weight, open: false } => self.measured.add(distance, weight),
            Evidence::Silhouette { distance, weight, open: true } => {
                self.open.add(distance, weight);
                self.n_open = self.n_open.saturating_add(1);
            }
            Evidence::Hidden => self.n_covered = self.n_covered.saturating_add(1),
        }
    }

    /// Returns the total evidence. Rays without return are ignored if more frames show a surface at the voxel
    /// or in front of it.
    fn sums(&self) -> DistanceSums {
        let Self { measured, open, n_open, n_covered } = *self;
        if n_covered > n_open {
            return measured;
        }
        DistanceSums {
            distance: measured.distance + open.distance,
            weight: measured.weight + open.weight,
            free: measured.free + open.free,
        }
    }
}

impl DistanceSums {
    fn add(&mut self, distance: f32, weight: f32) {
        self.distance += weight * distance;
        self.weight += weight;
    }
}
