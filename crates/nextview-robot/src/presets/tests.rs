use super::{NAMES, urdf};
use crate::Arm;
use glam::{DMat4, DVec3};
use nextview::geometry::Pose;
use nextview::geometry::random::Random;
use std::f64::consts::FRAC_PI_2;

#[test]
fn every_preset_is_an_arm_with_solids() {
    for name in NAMES {
        let arm = Arm::preset(name).unwrap();
        assert_eq!(arm.name, name);
        assert_eq!(arm.n_joints(), if name == "panda" { 7 } else { 6 });
        assert!(arm.links.iter().all(|link| !link.shapes.is_empty()), "{name}");
        assert!(arm.joints.iter().all(|joint| joint.limits.lower < joint.limits.upper), "{name}");
    }
    assert!(urdf("ur5").is_none());
    let error = Arm::preset("ur5").unwrap_err().to_string();
    assert!(error.starts_with("no arm is called \"ur5\", expected one of ur3e, ur5e"), "{error}");
}

/// A row of a Denavit-Hartenberg table: d, a and alpha of the joint with its theta, in the textbook order
/// (turn and move along z, then along x), or in Craig's (x first).
struct Row(f64, f64, f64);

fn by_table(rows: &[Row], values: &[f64], is_craig: bool) -> DMat4 {
    rows.iter().zip(values).fold(DMat4::IDENTITY, |base, (Row(d, a, alpha), value)| {
        let along_z = DMat4::from_rotation_z(*value) * DMat4::from_translation(DVec3::Z * *d);
        let along_x = DMat4::from_translation(DVec3::X * *a) * DMat4::from_rotation_x(*alpha);
        if is_craig { base * along_x * along_z } else { base * along_z * along_x }
    })
}

fn assert_near(pose: Pose, expected: DMat4) {
    let found = DMat4::from_rotation_translation(pose.rotation(), pose.translation());
    assert!(found.abs_diff_eq(expected, 1e-12), "{found}\n{expected}");
}

fn random_values(arm: &Arm, random: &mut Random) -> Vec<f64> {
    arm.joints.iter().map(|joint| random.range(joint.limits.lower, joint.limits.upper)).collect()
}

/// The manufacturers' tables.
#[test]
fn presets_follow_the_tables_of_their_makers() {
    let ur = |[d1, a2, a3, d4, d5, d6]: [f64; 6]| {
        vec![
            Row(d1, 0.0, FRAC_PI_2),
            Row(0.0, a2, 0.0),
            Row(0.0, a3, 0.0),
            Row(d4, 0.0, FRAC_PI_2),
            Row(d5, 0.0, -FRAC_PI_2),
            Row(d6, 0.0, 0.0),
        ]
    };
    let panda = vec![
        Row(0.333, 0.0, 0.0),
        Row(0.0, 0.0, -FRAC_PI_2),
        Row(0.316, 0.0, FRAC_PI_2),
        Row(0.0, 0.0825, FRAC_PI_2),
        Row(0.384, -0.0825, -FRAC_PI_2),
        Row(0.0, 0.0, FRAC_PI_2),
        Row(0.0, 0.088, FRAC_PI_2),
    ];
    let tables = [
        ("ur3e", ur([0.15185, -0.24355, -0.2132, 0.13105, 0.08535, 0.0921]), false),
        ("ur5e", ur([0.1625, -0.425, -0.3922, 0.1333, 0.0997, 0.0996]), false),
        ("ur10e", ur([0.1807, -0.6127, -0.57155, 0.17415, 0.11985, 0.11655]), false),
        ("panda", panda, true),
    ];
    let mut random = Random::new(1, 0);
    for (name, rows, is_craig) in tables {
        let arm = Arm::preset(name).unwrap();
        let flange = if is_craig { 0.107 } else { 0.0 };
        for _ in 0..100 {
            let values = random_values(&arm, &mut random);
            let expected = by_table(&rows, &values, is_craig);
            assert_near(arm.forward(&values), expected * DMat4::from_translation(DVec3::Z * flange));
        }
    }
}

/// Reach and posture as drawn in the data sheets of KUKA and Fanuc.
#[test]
fn arms_without_a_table_stand_as_drawn() {
    let kuka = Arm::preset("kr6_r900").unwrap();
    let upright = kuka.forward(&[0.0, -FRAC_PI_2, FRAC_PI_2, 0.0, 0.0, 0.0]);
    assert!(upright.translation().abs_diff_eq(DVec3::new(0.025 + 0.42 + 0.08, 0.0, 0.89), 1e-12));
    assert!(upright.rotation().mul_vec3(DVec3::Z).abs_diff_eq(DVec3::X, 1e-12), "z outward");
    let left = kuka.forward(&[-FRAC_PI_2, 0.0, 0.0, 0.0, 0.0, 0.0]).translation();
    assert!(left.y > 0.9, "A1 turns clockwise");
    let lifted = kuka.forward(&[0.0, -0.5, 0.0, 0.0, 0.0, 0.0]).translation();
    assert!(lifted.z > 0.6, "A2 turns downwards");

    let fanuc = Arm::preset("lr_mate_200id").unwrap();
    let zero = fanuc.forward(&[0.0; 6]);
    assert!(zero.translation().abs_diff_eq(DVec3::new(0.05 + 0.335 + 0.08, 0.0, 0.695), 1e-12));
    assert!(zero.rotation().mul_vec3(DVec3::Z).abs_diff_eq(DVec3::X, 1e-12), "z outward");
    assert!(fanuc.forward(&[0.0, 0.0, 0.5, 0.0, 0.0, 0.0]).translation().z > 0.8, "J3 turns upwards");
    let wrist = |arm: &Arm, values: &[f64]| arm.link_poses(values)[5].translation();
    let reach = wrist(&fanuc, &[0.0, FRAC_PI_2, FRAC_PI_2 - (0.035_f64 / 0.335).atan(), 0.0, 0.0, 0.0]);
    assert!((reach.x - 0.717).abs() < 5e-4, "the data sheet's reach of 717 mm, found {}", reach.x);
}
