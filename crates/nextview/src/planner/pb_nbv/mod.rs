mod ellipsoid;
mod mixture;
mod projection;

use super::{Choice, Plan, Situation, ViewPlanner, utility};
use crate::geometry::{Pose, VoxelKey};
use crate::map::{Occupancy, Snapshot, frontier};
use crate::sensor::Intrinsics;
use crate::{Cancel, Cancelled, Error};
use ellipsoid::Ellipsoid;
use glam::DVec3;
use mixture::clusters;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Takes the view whose image is filled most by frontier ellipsoids and least by occupied ones: PB-NBV (Jia
/// et al., RA-L 2025). It casts no rays.
///
/// A few ellipsoids represent the occupied voxels and others the frontier: the smallest ones around the
/// clusters of a Gaussian mixture of smallest BIC. An ellipsoid counts the area of its image in pixels,
/// halved for each ellipsoid of either kind whose centre is nearer to the camera. There is no choice without
/// a frontier.
///
/// Views are chosen from all candidates at once, without the paper's sectors, which protect the alignment of
/// frames.
#[derive(Clone, Copy, Debug)]
pub struct PbNbv;

impl ViewPlanner for PbNbv {
    fn plan(&mut self, situation: &Situation<'_>) -> Result<Plan, Error> {
        let (snapshot, cancel) = (situation.snapshot(), situation.cancel());
        let frontier = frontier(snapshot);
        if frontier.is_empty() {
            return Ok(Plan::default());
        }
        let is_occupied = |&voxel: &usize| snapshot.occupancy()[voxel] == Occupancy::Occupied;
        let occupied: Vec<usize> = (0..snapshot.block().n_voxels()).filter(is_occupied).collect();
        let scene = Ellipsoids {
            frontier: ellipsoids(snapshot, &frontier, cancel)?,
            occupied: ellipsoids(snapshot, &occupied, cancel)?,
        };
        let rate = |view: usize| {
            let score = scene.score(&situation.views().pose(view), situation.intrinsics());
            cancel.check().map(|()| Choice::new(view, score))
        };
        let rated = situation.open_views().into_par_iter().map(rate);
        let choice = utility::best(rated.collect::<Result<Vec<_>, Cancelled>>()?.into_iter());
        let explanation = [
            ("frontier_ellipsoids", scene.frontier.len() as f64),
            ("occupied_ellipsoids", scene.occupied.len() as f64),
        ];
        let choice = choice.map(|choice| Choice { explanation: Some(explanation.into()), ..choice });
        Ok(Plan { choice, ..Plan::default() })
    }
}

/// The ellipsoids that represent the map, in world coordinates.
struct Ellipsoids {
    frontier: Vec<Ellipsoid>,
    occupied: Vec<Ellipsoid>,
}

impl Ellipsoids {
    /// The paper's F: pixels of frontier ellipsoids minus pixels of occupied ones, halved with each step back
    /// in the order of depth.
    fn score(&self, world_from_camera: &Pose, intrinsics: &Intrinsics) -> f64 {
        let camera_from_world = world_from_camera.inverse();
        let signed = |sign: f64| {
            move |ellipsoid: &Ellipsoid| {
                let area = projection::area(ellipsoid, &camera_from_world, intrinsics);
                (projection::depth(ellipsoid, &camera_from_world), sign * area)
            }
        };
        let mut images: Vec<(f64, f64)> = self.frontier.iter().map(signed(1.0)).collect();
        images.extend(self.occupied.iter().map(signed(-1.0)));
        // A stable sort: equal depths keep their order.
        images.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (mut score, mut weight) = (0.0, 1.0);
        for (_, area) in images {
            score += weight * area;
            weight *= 0.5;
        }
        score
    }
}

/// The ellipsoids that represent these voxels.
fn ellipsoids(snapshot: &Snapshot, voxels: &[usize], cancel: &Cancel) -> Result<Vec<Ellipsoid>, Cancelled> {
    let (lattice, block) = (snapshot.lattice(), snapshot.block());
    // Relative to the block, positions are small numbers wherever the object is.
    let local = |voxel: &usize| block.key(*voxel) - block.min();
    let centers: Vec<DVec3> = voxels.iter().map(|voxel| local(voxel).as_dvec3() + 0.5).collect();
    let around = |cluster: Vec<usize>| {
        let corners = corners(cluster.into_iter().map(|place| local(&voxels[place])));
        let ellipsoid = Ellipsoid::around(&corners, cancel)?;
        Ok(ellipsoid.scaled(lattice.voxel_size(), lattice.bounds(&block).min))
    };
    clusters(&centers, cancel)?.into_par_iter().map(around).collect()
}

/// The corners of voxels, except those between two others along x, which do not affect an ellipsoid.
fn corners(voxels: impl Iterator<Item = VoxelKey>) -> Vec<DVec3> {
    let mut rows: BTreeMap<[i32; 2], (i32, i32)> = BTreeMap::new();
    for voxel in voxels {
        for (y, z) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let (low, high) = rows.entry([voxel.z + z, voxel.y + y]).or_insert((voxel.x, voxel.x + 1));
            (*low, *high) = ((*low).min(voxel.x), (*high).max(voxel.x + 1));
        }
    }
    let ends = rows.into_iter().flat_map(|([z, y], (low, high))| [[low, y, z], [high, y, z]]);
    ends.map(|[x, y, z]| DVec3::new(x as f64, y as f64, z as f64)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::random::Random;
    use crate::view::look_at;
    use glam::{DMat3, IVec3};

    fn ball(center: DVec3, radius: f64) -> Ellipsoid {
        Ellipsoid { center, shape: DMat3::from_diagonal(DVec3::splat(radius * radius)) }
    }

    /// The slow twin: the rank of an ellipsoid is the number of those before it.
    #[test]
    fn the_score_is_that_of_the_paper() {
        let mut random = Random::new(3, 0);
        let mut balls = |n: usize| -> Vec<Ellipsoid> {
            (0..n).map(|_| ball(random.in_cube() * 0.1, random.range(0.005, 0.03))).collect()
        };
        let scene = Ellipsoids { frontier: balls(5), occupied: balls(4) };
        let camera = Intrinsics::d435i();
        for position in [DVec3::X, DVec3::new(-0.3, 0.3, 0.4), DVec3::new(0.0, 0.2, -0.35)] {
            let pose = look_at(position, DVec3::ZERO).unwrap();
            let depth = |e: &Ellipsoid| pose.inverse().transform_point(e.center).z;
            let of = |e: &Ellipsoid| {
                let all = scene.frontier.iter().chain(&scene.occupied);
                let rank = all.filter(|other| depth(other) < depth(e)).count() as i32;
                projection::area(e, &pose.inverse(), &camera) * 0.5_f64.powi(rank)
            };
            let expected =
                scene.frontier.iter().map(of).sum::<f64>() - scene.occupied.iter().map(of).sum::<f64>();
            assert!((scene.score(&pose, &camera) - expected).abs() < 1e-9 * expected.abs());
        }
    }

    #[test]
    fn an_occupied_ellipsoid_behind_all_others_lowers_the_score() {
        let pose = look_at(DVec3::X * 0.5, DVec3::ZERO).unwrap();
        let scene =
            |occupied: Vec<Ellipsoid>| Ellipsoids { frontier: vec![ball(DVec3::X * 0.05, 0.02)], occupied };
        let score = |occupied| scene(occupied).score(&pose, &Intrinsics::d435i());
        assert!(score(vec![ball(DVec3::X * -0.1, 0.02)]) < score(Vec::new()));
    }

    /// The slow twin: the ellipsoid around all corners of all voxels is the same, to the tolerance.
    #[test]
    fn corners_within_a_row_do_not_matter() {
        let mut random = Random::new(4, 0);
        let voxels: Vec<IVec3> =
            (0..60).map(|_| (random.in_cube() * DVec3::new(9.0, 3.0, 2.0)).as_ivec3()).collect();
        let of_voxel = |voxel: &IVec3| {
            let voxel = voxel.as_dvec3();
            [0, 1, 2, 3, 4, 5, 6, 7]
                .map(|i| voxel + DVec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64))
        };
        let all: Vec<DVec3> = voxels.iter().flat_map(of_voxel).collect();
        let around = |points: &[DVec3]| Ellipsoid::around(points, &Cancel::default()).unwrap();
        let (found, expected) = (around(&corners(voxels.iter().copied())), around(&all));
        assert!((found.shape.determinant() / expected.shape.determinant() - 1.0).abs() < 0.03);
        assert!(found.center.distance(expected.center) < 0.1);
    }
}
