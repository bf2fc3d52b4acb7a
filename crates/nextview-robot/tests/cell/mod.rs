//! An arm like a UR5e with a camera on its flange, and its cell: a table, a wall, a box of unknown voxels.

#![allow(dead_code, clippy::unwrap_used, reason = "shared by tests and an example, each using a part")]

use glam::{DQuat, DVec3, UVec3};
use nextview::geometry::random::Random;
use nextview::geometry::{Plane, Pose};
use nextview_robot::collision::{Attachment, BlockedVoxels, Checker, Obstacle, ObstacleKind, touching_links};
use nextview_robot::{Arm, Joint, JointKind, JointLimits, Link, Shape, ShapeKind};
use std::f64::consts::{FRAC_PI_2, PI};

/// Distance from obstacles, metres.
pub const CLEARANCE: f64 = 0.01;

/// Side of a voxel, metres, and voxels along each axis of the unknown box.
pub const VOXEL: f64 = 0.01;
pub const N_VOXELS: u32 = 40;

fn pose(turn: DQuat, at: [f64; 3]) -> Pose {
    Pose::new(turn, DVec3::from_array(at)).unwrap()
}

fn cylinder(turn: DQuat, at: [f64; 3], radius: f64, length: f64) -> Shape {
    Shape { link_from_shape: pose(turn, at), kind: ShapeKind::Cylinder { radius, length } }
}

/// The frames of the joints are those of Denavit and Hartenberg; the links are cylinders.
pub fn arm() -> Arm {
    let (along_x, along_z) = (DQuat::from_rotation_y(FRAC_PI_2), DQuat::IDENTITY);
    let table = [
        (0.1625, 0.0, FRAC_PI_2, PI),
        (0.0, -0.425, 0.0, PI),
        (0.0, -0.3922, 0.0, PI),
        (0.1333, 0.0, FRAC_PI_2, PI),
        (0.0997, 0.0, -FRAC_PI_2, PI),
        (0.0996, 0.0, 0.0, PI),
    ];
    let mut parent_from_joint = Pose::IDENTITY;
    let joints = table.iter().enumerate().map(|(i, &(d, a, alpha, velocity))| {
        let upper = if i == 2 { PI } else { 2.0 * PI };
        let limits = JointLimits { lower: -upper, upper, velocity, acceleration: 5.0 };
        let joint = Joint {
            name: format!("joint {}", i + 1),
            kind: JointKind::Revolute,
            parent_from_joint,
            axis: DVec3::Z,
            limits,
        };
        parent_from_joint = pose(DQuat::from_rotation_x(alpha), [a, 0.0, d]);
        joint
    });
    let joints = joints.collect();
    let shapes = [
        ("base", vec![cylinder(along_z, [0.0, 0.0, 0.045], 0.075, 0.09)]),
        ("shoulder", vec![cylinder(along_z, [0.0, 0.0, 0.1625], 0.06, 0.13)]),
        (
            "upper arm",
            vec![
                cylinder(along_z, [0.0, 0.0, 0.1], 0.06, 0.15),
                cylinder(along_x, [-0.2125, 0.0, 0.13], 0.055, 0.425),
                cylinder(along_z, [-0.425, 0.0, 0.1], 0.055, 0.15),
            ],
        ),
        ("forearm", vec![cylinder(along_x, [-0.2, 0.0, 0.01], 0.045, 0.4)]),
        ("wrist 1", vec![cylinder(along_z, [0.0, 0.0, 0.1], 0.045, 0.13)]),
        ("wrist 2", vec![cylinder(along_z, [0.0, 0.0, 0.08], 0.045, 0.13)]),
        ("wrist 3", vec![cylinder(along_z, [0.0, 0.0, 0.08], 0.04, 0.04)]),
    ];
    let links = shapes.map(|(name, shapes)| Link { name: name.to_owned(), shapes }).to_vec();
    let mut arm = Arm {
        name: "like a UR5e".to_owned(),
        joints,
        links,
        last_link_from_flange: pose(DQuat::IDENTITY, [0.0, 0.0, 0.0996]),
        may_touch: vec![],
    };
    arm.may_touch = touching_links(&arm).unwrap();
    arm
}

pub fn camera() -> Attachment {
    let body = Shape {
        link_from_shape: pose(DQuat::from_rotation_z(0.4), [0.0, 0.05, 0.025]),
        kind: ShapeKind::Box(DVec3::new(0.06, 0.02, 0.0175)),
    };
    Attachment { name: "camera".to_owned(), shapes: vec![body] }
}

/// Which voxels of the unknown box are blocked: most of it, with a cone seen from one side.
pub fn blocked() -> Vec<bool> {
    let n = N_VOXELS;
    let mut random = Random::new(1, 0);
    let mut blocked = Vec::new();
    for z in 0..n {
        for y in 0..n {
            for x in 0..n {
                let at = (DVec3::new(x.into(), y.into(), z.into()) + 0.5) / f64::from(n) - 0.5;
                let is_object = at.length() < 0.25;
                let is_seen = at.x < 0.0 && at.truncate().length() < 0.45 && at.y.abs() + at.z.abs() < 0.4;
                blocked.push(is_object || !is_seen || random.unit() < 0.001);
            }
        }
    }
    blocked
}

pub fn base_from_grid() -> Pose {
    pose(DQuat::from_rotation_z(0.2), [0.35, -0.25, 0.0])
}

pub fn wall() -> (Pose, DVec3) {
    (pose(DQuat::from_rotation_z(-0.1), [0.1, 0.6, 0.5]), DVec3::new(1.0, 0.02, 0.5))
}

pub fn obstacles() -> Vec<Obstacle> {
    let voxels = BlockedVoxels::new(base_from_grid(), VOXEL, UVec3::splat(N_VOXELS), &blocked()).unwrap();
    let (base_from_shape, half) = wall();
    let kinds = [
        ("table", ObstacleKind::Below(Plane::horizontal(0.0).unwrap())),
        ("wall", ObstacleKind::Solid { base_from_shape, kind: ShapeKind::Box(half) }),
        ("unknown space", ObstacleKind::Voxels(voxels)),
    ];
    kinds.map(|(name, kind)| Obstacle { name: name.to_owned(), kind }).to_vec()
}

pub fn checker() -> Checker {
    Checker::new(arm(), vec![camera()], obstacles(), CLEARANCE).unwrap()
}

/// Random joint values within half a turn either way.
pub fn values(random: &mut Random) -> Vec<f64> {
    (0..6).map(|_| random.range(-PI, PI)).collect()
}

/// Random joint values without contact.
pub fn free_values(checker: &Checker, random: &mut Random) -> Vec<f64> {
    loop {
        let values = values(random);
        if checker.contact(&values).is_none() {
            return values;
        }
    }
}
