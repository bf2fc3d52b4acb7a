use super::CellError;
use super::gjk;
use super::solid::{Placement, Solid};
use glam::{DVec3, UVec3};
use nextview::geometry::Pose;

/// Blocked voxels of a regular grid: measured surface, or space not yet seen.
///
/// Blocks of blocked voxels are merged into an octree, which keeps solid space cheap.
#[derive(Clone, Debug)]
pub struct BlockedVoxels {
    base_from_grid: Placement,
    root: CubeNode,
    branches: Vec<[CubeNode; 8]>,
    /// Half the side of the root in metres.
    half: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum CubeNode {
    Free,
    Blocked,
    /// Number of the branch with the eight parts, x varying fastest.
    Mixed(usize),
}

impl BlockedVoxels {
    /// Maximum number of voxels along an axis.
    pub const MOST_ALONG: u32 = 1024;

    /// Creates a grid with its lowest corner at the origin of its frame; voxel `[x, y, z]` covers `[x, y, z]`
    /// to `[x + 1, y + 1, z + 1]` times `voxel_size_m`, 1e-4 to 10. `blocked` has a value for each voxel, x
    /// varying fastest, and 1 to [`MOST_ALONG`](Self::MOST_ALONG) voxels along each axis.
    pub fn new(
        base_from_grid: Pose,
        voxel_size_m: f64,
        dims: UVec3,
        blocked: &[bool],
    ) -> Result<Self, CellError> {
        let mut faults = Vec::new();
        if !(1e-4..=10.0).contains(&voxel_size_m) {
            faults.push(format!("voxel_size_m is {voxel_size_m}, expected 1e-4 to 10"));
        }
        if dims.min_element() == 0 || dims.max_element() > Self::MOST_ALONG {
            faults.push(format!("the grid has {dims} voxels, expected 1 to {} each way", Self::MOST_ALONG));
        } else if blocked.len() as u64 != dims.as_u64vec3().element_product() {
            faults.push(format!("there are {} values for {dims} voxels", blocked.len()));
        }
        CellError::unless_empty(faults)?;
        let side = dims.max_element().next_power_of_two();
        let mut branches = Vec::new();
        let root = build(&mut branches, UVec3::ZERO, side, dims, blocked);
        let half = 0.5 * f64::from(side) * voxel_size_m;
        Ok(Self { base_from_grid: base_from_grid.into(), root, branches, half })
    }

    /// A lower bound on the distance of a solid to the nearest blocked voxel: within 1e-4 of it, or at least
    /// `limit`. Below `enough`, it may be that of any blocked voxel this close.
    pub(super) fn distance(
        &self,
        solid: &Solid,
        base_from_solid: &Placement,
        limit: f64,
        enough: f64,
    ) -> f64 {
        let solid_from_grid = base_from_solid.inverse_times(&self.base_from_grid);
        let center = solid_from_grid.rotation * DVec3::splat(self.half) + solid_from_grid.translation;
        let mut search = CubeSearch { solid, placement: solid_from_grid, least: limit, enough };
        let bound = search.bound(center, self.half);
        self.visit(self.root, center, self.half, bound, &mut search);
        search.least
    }

    fn visit(&self, node: CubeNode, center: DVec3, half: f64, bound: f64, search: &mut CubeSearch) {
        if bound >= search.least || search.least < search.enough {
            return;
        }
        match node {
            CubeNode::Free => {}
            CubeNode::Blocked => search.meet(center, half),
            CubeNode::Mixed(branch) => {
                let half = 0.5 * half;
                let mut parts: [(f64, DVec3, CubeNode); 8] = std::array::from_fn(|i| {
                    let sign = |bit: usize| if i >> bit & 1 == 0 { -half } else { half };
                    let center = center + search.placement.rotation * DVec3::new(sign(0), sign(1), sign(2));
                    let node = self.branches[branch][i];
                    let is_free = node == CubeNode::Free;
                    (if is_free { f64::INFINITY } else { search.bound(center, half) }, center, node)
                });
                parts.sort_by(|a, b| a.0.total_cmp(&b.0));
                for (bound, center, node) in parts {
                    self.visit(node, center, half, bound, search);
                }
            }
        }
    }
}

/// A search for the blocked cube nearest to a solid, in the frame of the solid.
struct CubeSearch<'a> {
    solid: &'a Solid,
    /// Pose of the grid in the frame of the solid.
    placement: Placement,
    least: f64,
    enough: f64,
}

impl CubeSearch<'_> {
    /// A lower bound on the distance of the cube.
    fn bound(&self, center: DVec3, half: f64) -> f64 {
        self.solid.outside(center) - half * 3.0_f64.sqrt()
    }

    fn meet(&mut self, center: DVec3, half: f64) {
        let placement = Placement { rotation: self.placement.rotation, translation: center };
        self.least = self.least.min(gjk::distance(self.solid, &Solid::cube(half), &placement, self.least));
    }
}

fn build(
    branches: &mut Vec<[CubeNode; 8]>,
    low: UVec3,
    side: u32,
    dims: UVec3,
    blocked: &[bool],
) -> CubeNode {
    if low.cmpge(dims).any() {
        return CubeNode::Free;
    }
    if side == 1 {
        let [x, y, z] = low.to_array().map(|i| i as usize);
        let is_blocked = blocked[x + dims.x as usize * (y + dims.y as usize * z)];
        return if is_blocked { CubeNode::Blocked } else { CubeNode::Free };
    }
    let half = side / 2;
    let parts: [CubeNode; 8] = std::array::from_fn(|i| {
        let i = i as u32;
        build(branches, low + half * UVec3::new(i & 1, i >> 1 & 1, i >> 2), half, dims, blocked)
    });
    if parts[0] != CubeNode::Mixed(0) && parts.iter().all(|part| *part == parts[0]) {
        return parts[0];
    }
    branches.push(parts);
    CubeNode::Mixed(branches.len() - 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ShapeKind;
    use glam::DQuat;
    use nextview::geometry::random::Random;

    /// The slow twin visits all voxels.
    #[test]
    fn the_distance_is_that_of_the_nearest_blocked_voxel() {
        let mut random = Random::new(5, 0);
        for case in 0..60 {
            let dims = UVec3::new(1 + random.index(9) as u32, 1 + random.index(9) as u32, 7);
            let share = random.unit().powi(2);
            let n = dims.element_product() as usize;
            let blocked: Vec<bool> = (0..n).map(|_| random.unit() < share).collect();
            let turn = DQuat::from_rotation_x(random.range(0.0, 6.0)) * DQuat::from_rotation_z(1.0);
            let base_from_grid = Pose::new(turn, 0.3 * random.in_cube()).unwrap();
            let voxels = BlockedVoxels::new(base_from_grid, 0.05, dims, &blocked).unwrap();
            let kind = match case % 3 {
                0 => ShapeKind::Sphere(0.05),
                1 => ShapeKind::Cylinder { radius: 0.03, length: 0.3 },
                _ => ShapeKind::Hull((0..9).map(|_| 0.1 * random.in_cube()).collect()),
            };
            let (solid, _) = Solid::new(&kind);
            let base_from_solid = Placement::from(Pose::new(turn.inverse(), random.in_cube()).unwrap());
            let cube = Solid::cube(0.025);
            let slow = (0..n).filter(|i| blocked[*i]).map(|i| {
                let i = i as u32;
                let key = UVec3::new(i % dims.x, i / dims.x % dims.y, i / dims.x / dims.y);
                let at = base_from_grid.transform_point((key.as_dvec3() + 0.5) * 0.05);
                let base_from_cube = Placement { translation: at, ..Placement::from(base_from_grid) };
                gjk::distance(&solid, &cube, &base_from_solid.inverse_times(&base_from_cube), f64::INFINITY)
            });
            let slow = slow.fold(f64::INFINITY, f64::min);
            let found = voxels.distance(&solid, &base_from_solid, f64::INFINITY, 0.0);
            assert!(found == slow || (found - slow).abs() <= 2e-4 * slow + 1e-8, "{found}, {slow}");
            let limited = voxels.distance(&solid, &base_from_solid, 0.4, 0.2);
            assert!(limited <= 0.4 && (limited >= 0.2) == (slow >= 0.2), "{limited}, {slow}");
        }
    }

    #[test]
    fn solid_space_is_one_node() {
        let voxels = BlockedVoxels::new(Pose::IDENTITY, 0.01, UVec3::splat(64), &vec![true; 64 * 64 * 64]);
        assert_eq!(voxels.unwrap().root, CubeNode::Blocked);
        let error = BlockedVoxels::new(Pose::IDENTITY, 0.0, UVec3::new(1, 1, 0), &[]).unwrap_err();
        assert_eq!(
            error.to_string(),
            "voxel_size_m is 0, expected 1e-4 to 10; the grid has [1, 1, 0] voxels, expected 1 to 1024 each way"
        );
    }
}
