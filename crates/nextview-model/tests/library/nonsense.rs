//! The public interface, given nonsense: not a number, infinite, huge, tiny, zero, nothing. It returns errors
//! or answers, without a panic and within bounds of time and memory.

#![allow(clippy::unwrap_used, reason = "helpers of a test")]

use glam::{DVec2, DVec3, IVec3, UVec3};
use nextview::Cancel;
use nextview::geometry::{Aabb, Lattice, Plane, VoxelBlock};
use nextview::sensor::{DepthImage, Frame, Intrinsics};
use nextview::surface::{CloudPoint, downsample, frame_points};
use nextview::view::look_at;
use nextview_model::{DistanceField, Floor, fused_cloud, take_nearest};
use proptest::prelude::*;

/// A number that nobody means, or a plain one.
fn number() -> impl Strategy<Value = f64> {
    let nonsense = [
        f64::NAN,
        f64::INFINITY,
        f64::NEG_INFINITY,
        f64::MAX,
        1e300,
        1e30,
        -1e8,
        0.0,
        -0.0,
        f64::MIN_POSITIVE,
        1e-9,
    ];
    prop_oneof![2 => prop::sample::select(nonsense.to_vec()), 1 => -1.0..1.0]
}

/// A number that may be a size.
fn size() -> impl Strategy<Value = f64> {
    prop_oneof![1 => number(), 1 => 0.001..0.1]
}

/// A vector that is often a place.
fn place() -> impl Strategy<Value = DVec3> {
    let plain = prop::array::uniform3(-0.5..0.5).prop_map(DVec3::from_array);
    prop_oneof![2 => prop::array::uniform3(number()).prop_map(DVec3::from_array), 1 => plain]
}

/// A frame from a place where cameras can stand.
fn frame() -> impl Strategy<Value = Frame> {
    let camera = Intrinsics::pinhole(24, 18, DVec2::splat(20.0), DVec2::new(11.5, 8.5)).unwrap();
    let pose =
        (place(), place()).prop_filter_map("a pose", |(position, target)| look_at(position, target).ok());
    let depth = prop::collection::vec(number().prop_map(|x| x as f32), 24 * 18);
    (pose, depth, size()).prop_filter_map("a frame", move |(pose, depth, range)| {
        Frame::new(DepthImage::from_metres(24, 18, depth).ok()?, camera, pose, range).ok()
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn clouds(points in prop::collection::vec((place(), place()), 0..20), cell in size(), frame in frame()) {
        let never = &Cancel::default();
        let cloud = points.iter().map(|(position, normal)| CloudPoint {
            normal: normal.try_normalize(),
            color: Some([1, 2, 3]),
            ..CloudPoint::from(*position)
        });
        if let Ok(thinned) = downsample(cloud.clone(), cell) {
            take_nearest(&mut thinned.clone(), &thinned, cell, never).unwrap();
            let seen = frame_points(&frame, None, Aabb::cube(DVec3::ZERO, 1.0)).unwrap();
            for point in fused_cloud(cloud.chain(seen), cell, None, never).unwrap() {
                prop_assert!(point.position.is_finite());
            }
        }
    }

    #[test]
    fn meshes(cell in size(), frame in frame()) {
        let never = &Cancel::default();
        let block = VoxelBlock::new(IVec3::splat(-4), UVec3::splat(8)).unwrap();
        if let Ok(lattice) = Lattice::new(cell)
            && let Ok(mut field) = DistanceField::new(lattice, block, 2.0 * cell)
        {
            field.integrate(&frame, never).unwrap();
            for vertex in field.surface(never).unwrap().vertices {
                prop_assert!(vertex.is_finite());
            }
            let plane = Plane::horizontal(0.0).unwrap();
            let _ = field.watertight_surface(Some(&Floor { plane, clearance: cell }), never);
        }
    }
}
