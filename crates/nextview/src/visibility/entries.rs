use super::pass_grid::PassGrid;
use crate::geometry::VoxelBlock;
use crate::geometry::lanes::{FIRST_INDEX, LANES, Lanes, cell, load, store};
use crate::sensor::Points;
use glam::{DMat3, DVec2, DVec3, IVec3, UVec3};
use pulp::{Arch, Simd, WithSimd};

/// Where rays enter the voxels that weaken them: the bricks of a grid with voxels that weaken a ray and lie
/// next to clear ones or at the border of the block.
///
/// A ray that comes from outside and passes none of these bricks is never weakened. Most rays of a view are
/// of this kind, and [`Tiles`] identify them without a walk.
#[derive(Debug)]
pub(super) struct Entries {
    /// [`LANES`] at a time; the last one is repeated.
    bricks: Vec<Bricks>,
    /// Radius of a ball around a brick, in voxels.
    radius: f64,
    /// The corners of the block, in voxels.
    corners: [DVec3; 8],
}

/// Bricks with faces through which rays enter.
#[derive(Debug)]
struct Bricks {
    /// Their middles along each axis, in voxels.
    middles: [Lanes; 3],
    /// Rays enter through a face across an axis only from beyond it: rays up the axis from below the first of
    /// these, rays down the axis from above the second.
    upward: [Lanes; 3],
    downward: [Lanes; 3],
}

/// A brick under construction.
#[derive(Clone, Copy)]
struct Brick {
    middle: DVec3,
    upward: DVec3,
    downward: DVec3,
}

/// Bricks along the longest side of the block: more would take longer to check than the rays they save.
const MOST_BRICKS: u32 = 32;

/// The part of an image, in tiles, that shows the bricks of [`Entries`].
#[derive(Debug)]
pub(super) struct Tiles {
    /// A bit for each tile of a row.
    rows: [u64; N_TILES],
    /// The middle of the first tile, on the plane z = 1.
    low: DVec2,
    /// Tiles in a length of 1.
    density: DVec2,
}

/// Tiles in a row, and rows.
const N_TILES: usize = 64;

impl Entries {
    /// Finds the entries; `None` if no voxel is clear, since every ray is then weakened at once.
    pub fn of(grid: &PassGrid) -> Option<Self> {
        if !grid.passes.contains(&1.0) {
            return None;
        }
        let edge = grid.block.dims().max_element().div_ceil(MOST_BRICKS);
        let (low, half) = (grid.block.min().as_dvec3(), 0.5 * edge as f64);
        let bricks = VoxelBlock::new(IVec3::ZERO, (grid.block.dims() + edge - 1) / edge)?;
        let brick = |index| Brick {
            middle: low + bricks.key(index).as_dvec3() * edge as f64 + half,
            upward: DVec3::NEG_INFINITY,
            downward: DVec3::INFINITY,
        };
        let mut all: Vec<Brick> = (0..bricks.n_voxels()).map(brick).collect();
        for_each_entry(grid, |key, axis, is_upward| {
            let place = (key - grid.block.min()) / edge as i32;
            let brick = &mut all[bricks.index(place).expect("the bricks cover the block")];
            // A thousandth beyond the face: far more than the rounding of a walk.
            if is_upward {
                brick.upward[axis] = brick.upward[axis].max(key[axis] as f64 + 1e-3);
            } else {
                brick.downward[axis] = brick.downward[axis].min(key[axis] as f64 + 1.0 - 1e-3);
            }
        });
        all.retain(|brick| brick.upward != DVec3::NEG_INFINITY || brick.downward != DVec3::INFINITY);
        let corner = |i: u32| {
            let upper = UVec3::new(i & 1, i >> 1 & 1, i >> 2);
            low + (upper * grid.block.dims()).as_dvec3()
        };
        Some(Self {
            bricks: all.chunks(LANES).map(Bricks::new).collect(),
            // A thousandth more, for the same reason.
            radius: 3.0_f64.sqrt() * half + 1e-3,
            corners: [0, 1, 2, 3, 4, 5, 6, 7].map(corner),
        })
    }

    /// Returns the tiles that show the entries to a camera at `origin`, in voxels, whose rays begin at a
    /// depth of `nearest`. `None` if they would save less than they cost for this number of rays, or if rays
    /// may begin inside the block.
    pub fn seen_from(
        &self,
        arch: Arch,
        rotation: &DMat3,
        origin: DVec3,
        nearest: f64,
        n_rays: usize,
    ) -> Option<Tiles> {
        // A brick costs an eighth of a ray.
        if self.bricks.len() * LANES > 4 * n_rays {
            return None;
        }
        let camera_from_world = rotation.transpose();
        let corners = self.corners.map(|corner| camera_from_world * (corner - origin));
        let least_depth = corners.iter().map(|corner| corner.z).fold(f64::INFINITY, f64::min);
        if least_depth <= nearest.max(2.0 * self.radius) {
            return None;
        }
        let on_plane = corners.map(|corner| corner.truncate() / corner.z);
        let low = on_plane.into_iter().fold(DVec2::INFINITY, DVec2::min);
        let high = on_plane.into_iter().fold(DVec2::NEG_INFINITY, DVec2::max);
        let mut tiles = Tiles { rows: [0; N_TILES], low, density: (N_TILES - 1) as f64 / (high - low) };
        // A length of 1 from a point of the block moves its image by at most this over the depth at its end.
        let slope = (1.0 + low.abs().max(high.abs()).length_squared()).sqrt();
        arch.dispatch(Mark { tiles: &mut tiles, entries: self, camera_from_world, origin, slope });
        Some(tiles)
    }
}

/// Visits all voxels in which rays can be weakened first, once for each face through which they come: with
/// its axis, and whether they come up the axis.
fn for_each_entry(grid: &PassGrid, mut visit: impl FnMut(IVec3, usize, bool)) {
    let strides = grid.padded.strides();
    let is_clear = |cell: usize| grid.passes[cell] == 1.0 || grid.passes[cell] == PassGrid::OUTSIDE;
    for cell in (0..grid.passes.len()).filter(|&cell| !is_clear(cell) && grid.passes[cell] != 0.0) {
        for (axis, stride) in strides.into_iter().enumerate() {
            if is_clear(cell - stride) {
                visit(grid.padded.key(cell), axis, true);
            }
            if is_clear(cell + stride) {
                visit(grid.padded.key(cell), axis, false);
            }
        }
    }
}

impl Bricks {
    fn new(bricks: &[Brick]) -> Self {
        let of_lane = |lane: usize| bricks[lane.min(bricks.len() - 1)];
        let in_lanes = |part: fn(Brick) -> DVec3| {
            [0, 1, 2].map(|axis| std::array::from_fn(|lane| part(of_lane(lane))[axis]))
        };
        Self {
            middles: in_lanes(|brick| brick.middle),
            upward: in_lanes(|brick| brick.upward),
            downward: in_lanes(|brick| brick.downward),
        }
    }

    /// Whether rays from a place can enter through the face.
    #[inline(always)]
    fn face<S: Simd>(&self, simd: S, origin: DVec3, part: usize) -> S::m64s {
        let mut faces = simd.less_than_f64s(simd.splat_f64s(0.0), simd.splat_f64s(0.0));
        for axis in 0..3 {
            let origin = simd.splat_f64s(origin[axis]);
            let upward = simd.less_than_f64s(origin, load::<S>(&self.upward[axis], part));
            let downward = simd.less_than_f64s(load::<S>(&self.downward[axis], part), origin);
            faces = simd.or_m64s(faces, simd.or_m64s(upward, downward));
        }
        faces
    }
}

impl Tiles {
    /// For each ray through these places of the plane z = 1, whether it passes a tile that shows an entry.
    #[inline(always)]
    pub fn show(&self, ideal: &Points<LANES>) -> [bool; LANES] {
        let (mut columns, mut rows, mut shown) = ([0.0; LANES], [0.0; LANES], [false; LANES]);
        for lane in 0..LANES {
            columns[lane] = tile((ideal.x[lane] - self.low.x) * self.density.x);
            rows[lane] = tile((ideal.y[lane] - self.low.y) * self.density.y);
        }
        for lane in 0..LANES {
            shown[lane] = self.rows[cell(rows[lane]) % N_TILES] >> cell(columns[lane]) & 1 == 1;
        }
        shown
    }
}

/// The tile nearest to a place, as an [index](cell). Bricks and rays are rounded alike, so a ray between the
/// borders of a brick has a tile between theirs.
#[inline(always)]
fn tile(place: f64) -> f64 {
    // Not `clamp`, which checks whether the limits are in order.
    let last = (N_TILES - 1) as f64;
    let place = if place > 0.0 { place } else { 0.0 };
    (if place < last { place } else { last }) + FIRST_INDEX
}

/// Marks the tiles that show entries.
struct Mark<'a> {
    tiles: &'a mut Tiles,
    entries: &'a Entries,
    camera_from_world: DMat3,
    origin: DVec3,
    slope: f64,
}

impl WithSimd for Mark<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for bricks in &self.entries.bricks {
            let (mut ends, mut faces) = ([[0.0; LANES]; 4], [0.0; LANES]);
            for part in 0..LANES / S::F64_LANES {
                let [x, y, z] = self.in_camera(simd, &bricks.middles, part);
                let reach = simd.div_f64s(simd.splat_f64s(self.slope * self.entries.radius), z);
                let (column, row) = (simd.div_f64s(x, z), simd.div_f64s(y, z));
                store::<S>(&mut ends[0], part, self.place(simd, 0, simd.sub_f64s(column, reach)));
                store::<S>(&mut ends[1], part, self.place(simd, 0, simd.add_f64s(column, reach)));
                store::<S>(&mut ends[2], part, self.place(simd, 1, simd.sub_f64s(row, reach)));
                store::<S>(&mut ends[3], part, self.place(simd, 1, simd.add_f64s(row, reach)));
                let is_seen = bricks.face(simd, self.origin, part);
                store::<S>(
                    &mut faces,
                    part,
                    simd.select_f64s(is_seen, simd.splat_f64s(1.0), simd.splat_f64s(0.0)),
                );
            }
            for lane in 0..LANES {
                if faces[lane] == 0.0 {
                    continue;
                }
                let (first, last) = (cell(ends[0][lane]), cell(ends[1][lane]));
                let bits = (u64::MAX >> (N_TILES - 1 - (last - first))) << first;
                for row in &mut self.tiles.rows[cell(ends[2][lane])..=cell(ends[3][lane])] {
                    *row |= bits;
                }
            }
        }
    }
}

impl Mark<'_> {
    #[inline(always)]
    fn in_camera<S: Simd>(&self, simd: S, middles: &[Lanes; 3], part: usize) -> [S::f64s; 3] {
        let x = simd.sub_f64s(load::<S>(&middles[0], part), simd.splat_f64s(self.origin.x));
        let y = simd.sub_f64s(load::<S>(&middles[1], part), simd.splat_f64s(self.origin.y));
        let z = simd.sub_f64s(load::<S>(&middles[2], part), simd.splat_f64s(self.origin.z));
        let at = [x, y, z];
        [self.along(simd, 0, at), self.along(simd, 1, at), self.along(simd, 2, at)]
    }

    #[inline(always)]
    fn along<S: Simd>(&self, simd: S, axis: usize, [x, y, z]: [S::f64s; 3]) -> S::f64s {
        let row = self.camera_from_world.row(axis);
        let along = simd.mul_f64s(simd.splat_f64s(row.x), x);
        let along = simd.add_f64s(along, simd.mul_f64s(simd.splat_f64s(row.y), y));
        simd.add_f64s(along, simd.mul_f64s(simd.splat_f64s(row.z), z))
    }

    /// See [`tile`].
    #[inline(always)]
    fn place<S: Simd>(&self, simd: S, axis: usize, at: S::f64s) -> S::f64s {
        let from_low = simd.sub_f64s(at, simd.splat_f64s(self.tiles.low[axis]));
        let place = simd.mul_f64s(from_low, simd.splat_f64s(self.tiles.density[axis]));
        let place = simd.max_f64s(place, simd.splat_f64s(0.0));
        let place = simd.min_f64s(place, simd.splat_f64s((N_TILES - 1) as f64));
        simd.add_f64s(place, simd.splat_f64s(FIRST_INDEX))
    }
}
