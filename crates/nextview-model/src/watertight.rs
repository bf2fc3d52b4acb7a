//! The surface of a scan, closed where nothing was measured.

use super::diffusion::diffuse;
use super::specks::{kept_vertices, only};
use super::surface_nets::surface_nets_unless;
use super::well_composed::{corners, fill_cavities, first_corners, make_well_composed};
use super::{DistanceField, SurfaceMesh};
use glam::IVec3;
use nextview::geometry::{Plane, VoxelBlock};
use nextview::{Cancel, Cancelled};

/// Distance inside or outside of a voxel placed there only for topology, in voxels. Not 0, so that no two
/// vertices coincide.
const BARELY: f32 = 0.1;

/// Largest distance of a floor below the block, as a share of its longest side; an object that is higher does
/// not stand on the floor.
const MAX_FLOOR_DEPTH: f64 = 0.25;

/// A closed surface, and which parts of it were measured.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WatertightMesh {
    /// The closed mesh: each edge belongs to two triangles, which use it in opposite directions.
    pub mesh: SurfaceMesh,
    /// By vertex, whether it was filled in: part of its surroundings was not measured.
    pub is_filled: Vec<bool>,
}

/// The floor under an object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Floor {
    /// The plane at which the object ends.
    pub plane: Plane,
    /// Height above the plane up to which measurements belong to the floor, metres.
    pub clearance: f64,
}

impl WatertightMesh {
    /// Returns the triangles whose vertices were all measured, with all vertices of the mesh.
    pub fn measured(&self) -> SurfaceMesh {
        let is_measured = |triangle: &&[u32; 3]| !self.touches_filled(triangle);
        let triangles = self.mesh.triangles.iter().filter(is_measured).copied().collect();
        SurfaceMesh { vertices: self.mesh.vertices.clone(), triangles }
    }

    /// Returns the share, 0..=1, of the area in triangles with a filled-in vertex; 0 for an empty mesh.
    pub fn filled_share(&self) -> f64 {
        let area = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|i| self.mesh.vertices[i as usize]);
            (b - a).cross(c - a).length()
        };
        let all: f64 = self.mesh.triangles.iter().map(area).sum();
        let filled = self.mesh.triangles.iter().filter(|triangle| self.touches_filled(triangle));
        if all > 0.0 { filled.map(area).sum::<f64>() / all } else { 0.0 }
    }

    fn touches_filled(&self, triangle: &[u32; 3]) -> bool {
        triangle.iter().any(|&i| self.is_filled[i as usize])
    }
}

impl DistanceField {
    /// Extracts the surface, closed where nothing was measured: a 2-manifold, oriented outwards, without the
    /// specks that [`surface`](Self::surface) removes. Empty if no surface was measured.
    ///
    /// 1. Voxels without a measurement take the value that diffuses into them from all others (Davis et al.
    ///    2002, in the limit), so that the surface continues smoothly. Nothing flows through the border of
    ///    the block: surface that reaches it continues up to it.
    /// 2. With a floor, measurements less than its clearance above it count as none, and the object ends at
    ///    its plane. If that lies a little below the block, so does the bottom of the object.
    /// 3. Everything ends at the border of the block.
    /// 4. Voxels are added until the boundary is a 2-manifold (well-composed), and cavities without access
    ///    are filled: no camera was in there.
    ///
    /// ```
    /// use glam::{DVec2, DVec3};
    /// use nextview::Cancel;
    /// use nextview::geometry::{Aabb, Lattice, Pose};
    /// use nextview::sensor::{DepthImage, Frame, Intrinsics};
    /// use nextview_model::DistanceField;
    ///
    /// // A square tile at 0.5 m, seen from the front only.
    /// let camera = Intrinsics::pinhole(64, 48, DVec2::splat(60.0), DVec2::new(31.5, 23.5)).unwrap();
    /// let is_tile = |i: usize| (i % 64).abs_diff(32) < 10 && (i / 64).abs_diff(24) < 10;
    /// let depth = (0..64 * 48).map(|i| if is_tile(i) { 0.5 } else { f32::INFINITY }).collect();
    /// let image = DepthImage::from_metres(64, 48, depth).unwrap();
    /// let frame = Frame::new(image, camera, Pose::IDENTITY, 1.0).unwrap();
    ///
    /// let lattice = Lattice::new(0.01).unwrap();
    /// let block = lattice.block_inside(&Aabb::cube(DVec3::Z * 0.5, 0.2)).unwrap();
    /// let mut field = DistanceField::new(lattice, block, 0.02).unwrap();
    /// field.integrate(&frame, &Cancel::default()).unwrap();
    /// let closed = field.watertight_surface(None, &Cancel::default()).unwrap();
    /// assert!(closed.filled_share() > 0.4, "the back of the tile");
    /// ```
    pub fn watertight_surface(
        &self,
        floor: Option<&Floor>,
        cancel: &Cancel,
    ) -> Result<WatertightMesh, Cancelled> {
        let mut solid = self.solid(floor, cancel)?;
        solid.make_manifold(-self.barely(), cancel)?;
        let SignedVoxels { block, values, is_known } = &solid;
        let distance = |index: usize| Some(f64::from(values[index]));
        let mesh = surface_nets_unless(&self.lattice(), block, distance, cancel)?;
        let is_crossed = |cell: &[usize; 8]| {
            let n_inside = cell.iter().filter(|&&i| values[i] < 0.0).count();
            (1..8).contains(&n_inside)
        };
        // In the order of the vertices: each cell crossed by the surface has one.
        let crossed = first_corners(block).map(|first| corners(block, first)).filter(is_crossed);
        let is_filled = crossed.map(|cell| cell.iter().any(|&i| !is_known[i]));
        let kept = kept_vertices(&mesh, |point| self.evidence_near(point));
        let is_filled = is_filled.zip(&kept).filter(|(_, kept)| **kept).map(|(filled, _)| filled).collect();
        Ok(WatertightMesh { mesh: only(mesh, &kept), is_filled })
    }

    /// Returns all voxels with a distance, surrounded by a layer outside.
    fn solid(&self, floor: Option<&Floor>, cancel: &Cancel) -> Result<SignedVoxels, Cancelled> {
        let inner = self.block_on(floor);
        let height = |key: IVec3, floor: &Floor| floor.plane.height(self.lattice().center(key));
        let is_floor = |key: IVec3| floor.is_some_and(|floor| height(key, floor) < floor.clearance);
        let measured = |key: IVec3| self.distance(key).filter(|_| !is_floor(key));
        let known: Vec<Option<f32>> = (0..inner.n_voxels()).map(|i| measured(inner.key(i))).collect();
        let mut values = diffuse(&inner, &known, cancel)?;
        if let Some(floor) = floor {
            let below = |i: usize| -height(inner.key(i), floor) as f32;
            values.iter_mut().enumerate().for_each(|(i, value)| *value = value.max(below(i)));
        }
        let is_known: Vec<bool> = known.iter().map(Option::is_some).collect();
        Ok(SignedVoxels { block: inner, values, is_known }.surrounded(self.barely()))
    }

    /// [`BARELY`], in metres.
    fn barely(&self) -> f32 {
        BARELY * self.lattice().voxel_size() as f32
    }

    /// Returns the block, extended down to the floor if that is slightly below.
    fn block_on(&self, floor: Option<&Floor>) -> VoxelBlock {
        let (block, lattice) = (self.block(), self.lattice());
        let Some(Floor { plane, .. }) = floor.filter(|floor| floor.plane.normal().z > 0.5) else {
            return block;
        };
        // Half a voxel more, to include the centres below the plane.
        let below =
            |corner: glam::DVec3| plane.height(corner) / plane.normal().z + 0.5 * lattice.voxel_size();
        let corners = lattice.bounds(&block).corners().into_iter();
        let lowest = lattice.bounds(&block).min.z;
        let depth = corners.filter(|corner| corner.z == lowest).map(below).fold(0.0, f64::max);
        let n_layers = (depth / lattice.voxel_size()).ceil();
        if n_layers > MAX_FLOOR_DEPTH * f64::from(block.dims().max_element()) {
            return block;
        }
        let layers = IVec3::Z * n_layers as i32;
        VoxelBlock::new(block.min() - layers, block.dims() + layers.as_uvec3()).unwrap_or(block)
    }
}

/// Voxels that all have a distance, negative inside.
struct SignedVoxels {
    block: VoxelBlock,
    values: Vec<f32>,
    /// Whether it was measured.
    is_known: Vec<bool>,
}

impl SignedVoxels {
    /// Adds a layer outside, all around. Each of its voxels is as far outside as the nearest voxel is from
    /// the surface, at least `barely`: surface at the border then ends halfway to the layer.
    fn surrounded(self, barely: f32) -> Self {
        let Self { block, values, is_known } = self;
        let around = VoxelBlock::new(block.min() - 1, block.dims() + 2).expect("hardly larger");
        let all = (0..around.n_voxels()).map(|i| {
            let key = around.key(i);
            block.index(key).map_or_else(
                || {
                    let nearest = block.index(key.clamp(block.min(), block.max())).expect("clamped");
                    (values[nearest].abs().max(barely), false)
                },
                |inner| (values[inner], is_known[inner]),
            )
        });
        let (values, is_known) = all.unzip();
        Self { block: around, values, is_known }
    }

    /// Makes the boundary a 2-manifold; added voxels get the value `inside`.
    fn make_manifold(&mut self, inside: f32, cancel: &Cancel) -> Result<(), Cancelled> {
        let added = make_well_composed(&self.block, &mut self.values, inside, cancel)?;
        let filled = fill_cavities(&self.block, &mut self.values, inside);
        for (is_known, (added, filled)) in self.is_known.iter_mut().zip(added.into_iter().zip(filled)) {
            *is_known &= !(added || filled);
        }
        Ok(())
    }
}

/// Each edge belongs to two triangles, which use it in opposite directions, and the volume is positive.
#[cfg(test)]
#[track_caller]
pub(super) fn assert_watertight(mesh: &SurfaceMesh) {
    use std::collections::BTreeSet;
    let edges = |&[a, b, c]: &[u32; 3]| [(a, b), (b, c), (c, a)];
    let all: Vec<(u32, u32)> = mesh.triangles.iter().flat_map(edges).collect();
    let distinct: BTreeSet<(u32, u32)> = all.iter().copied().collect();
    assert!(!all.is_empty() && all.len() == distinct.len(), "{} of {}", distinct.len(), all.len());
    assert!(distinct.iter().all(|&(a, b)| distinct.contains(&(b, a))), "open");
    let corners = mesh.triangles.iter().map(|t| t.map(|i| mesh.vertices[i as usize]));
    assert!(corners.map(|[a, b, c]| a.dot(b.cross(c))).sum::<f64>() > 0.0, "turned inwards");
}
