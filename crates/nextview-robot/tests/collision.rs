//! Contacts and distances of a whole arm.

mod cell;

use glam::DVec3;
use nextview::geometry::Pose;
use nextview::geometry::random::Random;
use nextview_robot::collision::{Checker, Obstacle, ObstacleKind, touching_links};
use nextview_robot::{JointKind, Shape, ShapeKind};

/// Points in a solid, its border included, in the frame of the base.
fn points(base_from_link: Pose, shape: &Shape, random: &mut Random) -> Vec<DVec3> {
    let base_from_shape = base_from_link * shape.link_from_shape;
    let mut inside = |_| match &shape.kind {
        ShapeKind::Box(half) => *half * random.in_cube(),
        ShapeKind::Cylinder { radius, length } => {
            let turn = random.range(0.0, std::f64::consts::TAU);
            let (sin, cos) = turn.sin_cos();
            let r = radius * random.unit().sqrt();
            DVec3::new(r * cos, r * sin, length * random.range(-0.5, 0.5))
        }
        _ => panic!("the arm has no other shapes"),
    };
    (0..150).map(|i| base_from_shape.transform_point(inside(i))).collect()
}

/// The slow twin draws points in all solids: none is nearer to anything than the distance, and where points
/// enter something, there is contact.
#[test]
fn sampled_points_are_no_nearer_than_the_distance() {
    let checker = cell::checker();
    let arm = checker.arm().clone();
    let grid_from_base = cell::base_from_grid().inverse();
    let blocked = cell::blocked();
    let (base_from_wall, half) = cell::wall();
    let mut random = Random::new(2, 0);
    let (mut n_free, mut n_contacts) = (0, 0);
    for _ in 0..150 {
        let values = cell::values(&mut random);
        let poses = arm.link_poses(&values);
        let mut parts: Vec<(usize, Vec<DVec3>)> = arm
            .links
            .iter()
            .enumerate()
            .map(|(i, link)| {
                (i, link.shapes.iter().flat_map(|shape| points(poses[i], shape, &mut random)).collect())
            })
            .collect();
        let flange = arm.forward(&values);
        parts.push((6, points(flange, &cell::camera().shapes[0], &mut random)));
        let mut nearest = f64::INFINITY;
        let mut is_in_voxel = false;
        for (_, points) in &parts[1..] {
            for &point in points {
                let in_wall = base_from_wall.inverse().transform_point(point);
                nearest = nearest.min(point.z).min((in_wall.abs() - half).max(DVec3::ZERO).length());
                let voxel = (grid_from_base.transform_point(point) / cell::VOXEL).floor();
                if voxel.cmpge(DVec3::ZERO).all() && voxel.cmplt(DVec3::splat(cell::N_VOXELS.into())).all() {
                    let [x, y, z] = voxel.to_array().map(|i| i as usize);
                    let n = cell::N_VOXELS as usize;
                    is_in_voxel |= blocked[x + n * (y + n * z)];
                }
            }
        }
        for b in 0..parts.len() {
            for a in 0..b {
                let may_touch = b < 7 && arm.may_touch.contains(&[a, b]);
                if parts[a].0 < parts[b].0 && !may_touch {
                    for p in &parts[a].1 {
                        nearest = parts[b].1.iter().map(|q| p.distance(*q)).fold(nearest, f64::min);
                    }
                }
            }
        }
        if is_in_voxel {
            nearest = 0.0;
        }
        let (distance, contact) = (checker.distance(&values), checker.contact(&values));
        assert!(distance <= nearest.max(0.0) + 1e-9, "{distance}, {nearest} at {values:?}");
        if contact.is_none() {
            n_free += 1;
            assert!(nearest > 0.0 && distance >= Checker::SELF_CLEARANCE);
        } else {
            n_contacts += 1;
            assert!(distance < cell::CLEARANCE);
        }
    }
    assert!(n_free > 10 && n_contacts > 50, "{n_free} free, {n_contacts} in contact");
}

#[test]
fn contacts_name_what_touches() {
    let checker = cell::checker();
    let up = [0.0, -1.57, 0.0, -1.57, 0.0, 0.0];
    assert_eq!(checker.contact(&up), None);
    let low = checker.contact(&[0.0, 0.3, 0.0, 0.0, 0.0, 0.0]).unwrap();
    assert_eq!(low.other, "table");
    let folded = checker.contact(&[0.0, -1.57, 3.0, 0.0, 0.0, 0.0]).unwrap();
    assert!(folded.to_string().contains(" touches "), "{folded}");
    assert_eq!(checker.contact(&up), None);
}

#[test]
fn neighbours_may_touch_and_no_link_that_need_not() {
    let expected: Vec<[usize; 2]> = (0..6).map(|i| [i, i + 1]).collect();
    assert_eq!(cell::arm().may_touch, expected);
}

#[test]
fn sizes_that_are_none_are_refused_all_at_once() {
    let kind = ObstacleKind::Solid { base_from_shape: Pose::IDENTITY, kind: ShapeKind::Sphere(f64::NAN) };
    let obstacle = Obstacle { name: "ball".to_owned(), kind };
    let mut arm = cell::arm();
    arm.links[2].shapes[0].kind = ShapeKind::Box(DVec3::new(1.0, 0.0, 1.0));
    arm.joints[1].limits.velocity = 0.0;
    arm.joints[4].limits.upper = f64::NAN;
    let error = Checker::new(arm, vec![], vec![obstacle], 0.0).unwrap_err();
    assert_eq!(
        error.to_string(),
        "clearance_m is 0, expected 0.001 to 1; joint 2: velocity 0 and acceleration 5, expected positive \
         numbers; joint 5: range -6.283185307179586 to NaN, expected a bounded range; upper arm: half of the \
         sides of a box is [1, 0, 1], expected positive metres; ball: radius of a sphere is NaN, expected \
         positive metres"
    );
}

/// A joint that turns without end has an infinite range.
#[test]
fn joints_may_turn_without_end_and_not_slide_without_end() {
    let mut arm = cell::arm();
    arm.joints[5].limits.lower = f64::NEG_INFINITY;
    arm.joints[5].limits.upper = f64::INFINITY;
    assert_eq!(touching_links(&arm).unwrap(), cell::arm().may_touch);
    arm.joints[5].kind = JointKind::Prismatic;
    assert!(touching_links(&arm).unwrap_err().to_string().contains("expected a bounded range"));
    arm.links.pop();
    let error = Checker::new(arm, vec![], vec![], 0.01).unwrap_err();
    assert!(error.to_string().starts_with("the arm has 6 links, expected one more than its 6 joints"));
}
