//! What a view shows against its rays, each cut with every voxel.

use crate::common::{crossed, directions};
use crate::synthetic::{half_seen_ball, nothing_measured, prior, random_snapshot, snapshot};
use glam::{DVec2, DVec3, IVec3, UVec3};
use nextview::Cancel;
use nextview::gain::ExpectedSurface;
use nextview::geometry::{Pose, VoxelBlock};
use nextview::map::{Occupancy, Snapshot};
use nextview::prior::SurfaceEstimate;
use nextview::sensor::{DepthRange, Distortion, Intrinsics};
use nextview::view::look_at;
use proptest::prelude::*;
use std::collections::BTreeMap;

/// Returns the item of a voxel; `None` if the voxel cannot hold surface.
fn item_of(estimate: &SurfaceEstimate, voxel: usize) -> Option<usize> {
    estimate.voxels().binary_search(&(voxel as u32)).ok()
}

/// What passes through each voxel.
fn passes(snapshot: &Snapshot, estimate: &SurfaceEstimate) -> Vec<f32> {
    let occupancy = snapshot.occupancy();
    let pass = |voxel: usize| match (occupancy[voxel], item_of(estimate, voxel)) {
        (Occupancy::Occupied, _) => 0.25,
        (Occupancy::Free, Some(_)) => 0.995,
        (Occupancy::Unknown, Some(item)) => (1.0 - estimate.stops(item)).clamp(0.001, 0.999),
        _ => 1.0,
    };
    (0..occupancy.len()).map(pass).collect()
}

/// The least box around all that weakens a ray.
fn inner_block(snapshot: &Snapshot, passes: &[f32]) -> VoxelBlock {
    let block = snapshot.block();
    let weakening = || (0..passes.len()).filter(|&voxel| passes[voxel] < 1.0).map(|voxel| block.key(voxel));
    let corners = weakening().reduce(IVec3::min).zip(weakening().reduce(IVec3::max));
    corners.map_or(block, |(low, high)| VoxelBlock::new(low, (high - low + 1).as_uvec3()).unwrap())
}

/// By item the largest visibility over all rays.
fn slow_visibilities(
    snapshot: &Snapshot,
    intrinsics: &Intrinsics,
    estimate: &SurfaceEstimate,
    ray_spacing: f64,
    pose: &Pose,
) -> BTreeMap<usize, f32> {
    let (passes, lattice, mut best) = (passes(snapshot, estimate), snapshot.lattice(), BTreeMap::new());
    let inner = inner_block(snapshot, &passes);
    let (spacing, bounds) = (ray_spacing * lattice.voxel_size(), lattice.bounds(&inner));
    for direction in directions(intrinsics, pose, &bounds, spacing) {
        let (origin, direction) = (lattice.to_voxels(pose.translation()), pose.rotation_matrix() * direction);
        let mut visibility = 1.0_f32;
        for key in crossed(inner, origin, direction) {
            if visibility < 0.03 {
                break;
            }
            let voxel = snapshot.block().index(key).unwrap();
            if let Some(item) = item_of(estimate, voxel) {
                let most = best.entry(item).or_insert(visibility);
                *most = visibility.max(*most);
            }
            visibility *= passes[voxel];
        }
    }
    best
}

/// The class of a class: five of visibility times five of facing.
fn class(visibility: f32, facing: f32) -> usize {
    let of_visibility = match visibility {
        v if v < 0.12 => 0,
        v if v < 0.3 => 1,
        v if v < 0.6 => 2,
        v if v < 0.9 => 3,
        _ => 4,
    };
    let of_facing = match facing {
        f if f < -0.5 => 0,
        f if f < -0.15 => 1,
        f if f < 0.15 => 2,
        f if f < 0.5 => 3,
        _ => 4,
    };
    5 * of_visibility + of_facing
}

/// Returns the number of voxels that the view shows.
pub fn check_view(
    snapshot: &Snapshot,
    camera: &Intrinsics,
    estimate: &SurfaceEstimate,
    spacing: f64,
    pose: &Pose,
) -> Result<usize, TestCaseError> {
    let measured = nothing_measured(snapshot);
    let range = DepthRange::default();
    let gain = ExpectedSurface::new(snapshot, camera, range, &measured, estimate, spacing).unwrap();
    let (mut evaluator, mut found, mut sum) = (gain.evaluator(), BTreeMap::new(), 0.0);
    for _ in 0..2 {
        // A second look shows the same: nothing is left of the first.
        (found, sum) = (BTreeMap::new(), 0.0);
        let mut is_told_twice = false;
        evaluator.survey(pose, |item, class| {
            is_told_twice |= found.insert(item, class).is_some();
            sum += estimate.shows(item, class) as f64;
        });
        prop_assert!(!is_told_twice);
    }
    let expected = slow_visibilities(snapshot, camera, estimate, spacing, pose);
    prop_assert_eq!(found.keys().collect::<Vec<_>>(), expected.keys().collect::<Vec<_>>());
    for (&item, &visibility) in &expected {
        let key = snapshot.block().key(estimate.voxels()[item] as usize);
        let to_camera = (pose.translation().as_vec3() - snapshot.lattice().center(key).as_vec3()).normalize();
        let facing = to_camera.dot(estimate.normal(item));
        prop_assert_eq!(found[&item].index(), class(visibility, facing), "{} {} {}", key, visibility, facing);
    }
    prop_assert_eq!(evaluator.gain(pose), sum);
    Ok(expected.len())
}

fn estimate(snapshot: &Snapshot, seed: u64) -> SurfaceEstimate {
    prior(seed).estimate(snapshot, &Cancel::default()).unwrap()
}

fn cameras() -> Vec<Intrinsics> {
    let pinhole = Intrinsics::pinhole(320, 240, DVec2::splat(300.0), DVec2::new(160.0, 120.0)).unwrap();
    let barrel = pinhole.with_distortion(Distortion::BrownConrady([-0.2, 0.03, 0.001, 0.002, 0.0])).unwrap();
    vec![pinhole, barrel, Intrinsics::d435i()]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn a_view_shows_what_its_rays_come_to(
        dims in prop::array::uniform3(1_u32..12), seed in 0..u64::MAX / 2, position in prop::array::uniform3(-0.4..0.4),
        target in prop::array::uniform3(-0.03..0.03), camera in 0_usize..3, spacing in 0.7..4.0,
    ) {
        let dims = UVec3::from_array(dims);
        let snapshot = random_snapshot(-(dims / 2).as_ivec3(), dims, seed);
        let pose = look_at(DVec3::from_array(position), DVec3::from_array(target)).unwrap();
        check_view(&snapshot, &cameras()[camera], &estimate(&snapshot, seed), spacing, &pose)?;
    }

    /// Rays go through a free margin, over a border, along and through a surface, and far into the unknown.
    #[test]
    fn of_a_half_seen_ball_too(seed in 0..u64::MAX / 2, position in prop::array::uniform3(-0.4..0.4)) {
        let pose = look_at(DVec3::from_array(position), DVec3::ZERO).unwrap();
        let ball = half_seen_ball();
        check_view(&ball, &Intrinsics::d435i(), &estimate(&ball, seed), 1.0, &pose)?;
    }
}

#[test]
fn a_view_that_misses_the_box_shows_nothing() {
    let (ball, camera) = (half_seen_ball(), Intrinsics::d435i());
    let estimate = estimate(&ball, 1);
    let shown = |pose: Pose| check_view(&ball, &camera, &estimate, 1.0, &pose).unwrap();
    // Not along the edges of voxels: a ray there may be said to cross either.
    let beside = DVec3::new(1.0, 0.0131, 0.0073);
    assert_eq!(shown(look_at(beside, 2.0 * beside).unwrap()), 0);
    assert_eq!(shown(look_at(beside, DVec3::new(1.0, 1.0, 0.0)).unwrap()), 0);
    assert!(shown(look_at(beside, DVec3::ZERO).unwrap()) > 0);
    assert!(
        shown(look_at(DVec3::new(0.0017, 0.0009, 0.0013), beside).unwrap()) > 0,
        "a camera inside the box"
    );
}

#[test]
fn where_all_is_known_nothing_is_shown() {
    let block = VoxelBlock::new(IVec3::splat(-4), UVec3::splat(8)).unwrap();
    let pose = look_at(DVec3::X, DVec3::ZERO).unwrap();
    for log_odds in [-0.4, 0.85] {
        let known = snapshot(block, |_| Some(log_odds));
        let shown = check_view(&known, &Intrinsics::d435i(), &estimate(&known, 1), 1.0, &pose);
        assert_eq!(shown.unwrap(), 0);
    }
}

#[test]
fn rays_are_a_positive_distance_apart() {
    let (snapshot, estimate) =
        (half_seen_ball(), prior(1).estimate(&half_seen_ball(), &Cancel::default()).unwrap());
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let (camera, range) = (Intrinsics::d435i(), DepthRange::default());
        let measured = nothing_measured(&snapshot);
        let error = ExpectedSurface::new(&snapshot, &camera, range, &measured, &estimate, bad).unwrap_err();
        assert_eq!(error.to_string(), format!("ray_spacing is {bad}, expected a positive number of voxels"));
    }
}
