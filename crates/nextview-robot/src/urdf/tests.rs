use super::{UrdfError, UrdfOptions};
use crate::{Arm, JointKind, ShapeKind};
use glam::{DQuat, DVec3};
use proptest::prelude::*;
use std::f64::consts::TAU;

/// Base, column (fixed), a turning joint, a sliding one, a flange (fixed); on the side, a turning finger, and
/// a lamp on the base.
const ROBOT: &str = r#"<?xml version="1.0"?>
<robot name="crane">
  <link name="base"><collision><geometry><box size="2 4 6"/></geometry></collision></link>
  <link name="column"><collision><origin xyz="0 0 1"/><geometry><sphere radius="0.5"/></geometry></collision></link>
  <link name="boom"/>
  <link name="slide"><collision><geometry><mesh filename="slide.stl" scale="2 2 -2"/></geometry></collision></link>
  <link name="flange"/>
  <link name="finger"><collision><geometry><cylinder radius="0.1" length="3"/></geometry></collision></link>
  <link name="lamp"/>
  <joint name="stand" type="fixed">
    <parent link="base"/><child link="column"/><origin xyz="0 0 1" rpy="0 0 1.5707963267948966"/>
  </joint>
  <joint name="turn" type="continuous">
    <parent link="column"/><child link="boom"/><origin xyz="0 0 1"/><axis xyz="0 0 -2"/>
    <limit velocity="1.5" effort="1"/>
  </joint>
  <joint name="push" type="prismatic">
    <parent link="boom"/><child link="slide"/><limit lower="-0.5" upper="1" velocity="0.2" effort="1"/>
  </joint>
  <joint name="mount" type="fixed"><parent link="slide"/><child link="flange"/><origin xyz="3 0 0"/></joint>
  <joint name="bend" type="revolute">
    <parent link="flange"/><child link="finger"/><axis xyz="0 1 0"/>
    <limit lower="0.25" upper="1" velocity="1" effort="1"/>
  </joint>
  <joint name="hook" type="floating"><parent link="base"/><child link="lamp"/></joint>
</robot>"#;

fn tetrahedron(_: &str) -> Result<Vec<DVec3>, String> {
    Ok(vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z])
}

fn options() -> UrdfOptions<'static> {
    UrdfOptions { tip_link: Some("flange"), load_mesh: &tetrahedron, ..UrdfOptions::default() }
}

fn read(text: &str) -> Result<Arm, UrdfError> {
    Arm::from_urdf(text, &options())
}

#[test]
fn a_chain_is_read_and_fixed_parts_are_folded() {
    let arm = read(ROBOT).unwrap();
    assert_eq!((arm.name.as_str(), arm.n_joints()), ("crane", 2));
    let names: Vec<&str> = arm.links.iter().map(|link| link.name.as_str()).collect();
    assert_eq!(names, ["base", "boom", "slide"]);
    assert_eq!(arm.may_touch, [[0, 1], [1, 2]]);

    let [turn, push] = &arm.joints[..] else { panic!("two joints") };
    assert_eq!((turn.kind, push.kind), (JointKind::Revolute, JointKind::Prismatic));
    assert_eq!((turn.axis, push.axis), (-DVec3::Z, DVec3::X));
    assert_eq!([turn.limits.lower, turn.limits.upper], [-TAU, TAU]);
    assert_eq!([turn.limits.velocity, turn.limits.acceleration], [1.5, 3.0]);
    assert_eq!([push.limits.lower, push.limits.upper], [-0.5, 1.0]);

    // The column turns by 90°: the boom points to y; then by -30°.
    let flange = arm.forward(&[30.0_f64.to_radians(), 0.5]);
    let along = DQuat::from_rotation_z(60.0_f64.to_radians()) * DVec3::X;
    assert!(flange.translation().abs_diff_eq(3.5 * along + 2.0 * DVec3::Z, 1e-12));

    let base: Vec<&ShapeKind> = arm.links[0].shapes.iter().map(|shape| &shape.kind).collect();
    assert_eq!(base, [&ShapeKind::Box(DVec3::new(1.0, 2.0, 3.0)), &ShapeKind::Sphere(0.5)]);
    assert_eq!(arm.links[0].shapes[1].link_from_shape.translation(), 2.0 * DVec3::Z);
    let [slide, finger] = &arm.links[2].shapes[..] else { panic!("two shapes") };
    let ShapeKind::Hull(points) = &slide.kind else { panic!("a hull") };
    assert_eq!(points[3], -2.0 * DVec3::Z, "scaled");
    assert_eq!(finger.kind, ShapeKind::Cylinder { radius: 0.1, length: 3.0 });
    let held = DQuat::from_rotation_y(0.25);
    assert!(finger.link_from_shape.rotation().abs_diff_eq(held, 1e-12), "at the limit nearest to 0");
}

#[test]
fn names_in_capitals_are_told_and_not_skipped() {
    for (word, with_capitals) in [("<collision>", "<Collision>"), ("rpy=", "RPY="), ("<axis", "<Axis")] {
        let text = ROBOT.replace(word, with_capitals);
        let text =
            text.replace("</collision>", if word == "<collision>" { "</Collision>" } else { "</collision>" });
        let error = read(&text).unwrap_err().to_string();
        let known = word.trim_matches(['<', '>', '=']);
        assert!(error.contains(&format!("has capitals, expected `{known}`")), "{error}");
    }
}

#[test]
fn angles_turn_about_fixed_axes_in_the_order_x_y_z() {
    let turned = ROBOT.replace("rpy=\"0 0 1.5707963267948966\"", "rpy=\"0.3 -0.4 0.5\"");
    let rotation = read(&turned).unwrap().joints[0].parent_from_joint.rotation();
    let expected = DQuat::from_rotation_z(0.5) * DQuat::from_rotation_y(-0.4) * DQuat::from_rotation_x(0.3);
    assert!(rotation.abs_diff_eq(expected, 1e-12));
}

#[test]
fn base_and_tip_may_be_anywhere() {
    let text = ROBOT;
    let boom = UrdfOptions { base_link: Some("boom"), ..options() };
    assert_eq!(Arm::from_urdf(text, &boom).unwrap().links[0].name, "boom");
    let ring = text.replace("type=\"floating\"", "type=\"fixed\"");
    let found = UrdfOptions { tip_link: None, ..options() };
    let arm = Arm::from_urdf(&ring, &found).unwrap();
    assert_eq!(arm.n_joints(), 3, "the finger is the only end that moves");
}

/// The faults of a modified file, without their lines.
fn faults(text: &str, options: &UrdfOptions) -> Vec<String> {
    let faults = Arm::from_urdf(text, options).unwrap_err().faults;
    faults.iter().map(|fault| format!("{}: {}", fault.place, fault.problem)).collect()
}

#[test]
fn every_fault_says_what_and_where() {
    let changed = |from: &str, to: &str| {
        assert!(ROBOT.contains(from), "{from}");
        faults(&ROBOT.replacen(from, to, 1), &options()).join("\n")
    };
    let push = "lower=\"-0.5\" upper=\"1\" velocity=\"0.2\"";
    let cases = [
        ("</robot>", "", "URDF: is not well-formed XML: the root node was opened but never closed"),
        ("<robot ", "<sdf ", "URDF: is not well-formed XML"),
        ("<link name=\"boom\"/>", "<link/>", "link: `name` is missing, expected a name"),
        ("<link name=\"boom\"/>", "", "joint \"turn\": its child is \"boom\", expected the name of a link"),
        (
            "\"boom\"/>",
            "\"boom\"/><link name=\"boom\"/>",
            "link \"boom\": the name is already taken by the link in",
        ),
        (
            "joint name=\"push\"",
            "joint name=\"turn\"",
            "joint \"turn\": the name is already taken by the joint in line",
        ),
        (
            "<parent link=\"base\"/><child link=\"column\"/>",
            "<parent link=\"flange\"/><child link=\"column\"/>",
            "robot: link \"column\" is in a loop of joints, expected a tree",
        ),
        (
            "\"boom\"/>",
            "\"boom\"/><link name=\"alone\"/>",
            "robot: has several trees, with the roots \"base\", \"alone\", expected one tree",
        ),
        (
            "<child link=\"lamp\"/>",
            "<child link=\"boom\"/>",
            "joint \"hook\": link \"boom\" is already the child of joint \"turn\", expected one joint above \
             each link",
        ),
        ("<child link=\"lamp\"/>", "", "joint \"hook\": <child> is missing, expected the name of a link"),
        (
            "<limit velocity=\"1.5\" effort=\"1\"/>",
            "",
            "joint \"turn\": <limit> is missing, expected one with `velocity`",
        ),
        (
            push,
            "upper=\"1\" velocity=\"0.2\"",
            "joint \"push\", limit: `lower` is missing, expected a finite number of at most 1e6",
        ),
        (
            push,
            "lower=\"2\" upper=\"1\" velocity=\"0.2\"",
            "joint \"push\", limit: `lower` is 2, expected at most `upper`, 1",
        ),
        (push, "lower=\"0\" upper=\"inf\" velocity=\"0.2\"", "joint \"push\", limit: `upper` is \"inf\""),
        (
            push,
            "lower=\"0\" upper=\"1\" velocity=\"0\"",
            "joint \"push\", limit: `velocity` is 0, expected a positive number",
        ),
        (push, "lower=\"0\" upper=\"1\"", "joint \"push\", limit: `velocity` is missing"),
        ("\"0 0 -2\"", "\"0 0 0\"", "joint \"turn\", axis: `xyz` is \"0 0 0\", expected a direction"),
        ("\"0 0 -2\"", "\"0 0\"", "joint \"turn\", axis: `xyz` is \"0 0\", expected 3 finite numbers"),
        (
            "xyz=\"3 0 0\"",
            "xyz=\"3 NaN 0\"",
            "joint \"mount\", origin: `xyz` is \"3 NaN 0\", expected 3 finite",
        ),
        ("type=\"prismatic\"", "type=\"planar\"", "joint \"push\": is planar, expected revolute, continuous"),
        ("type=\"prismatic\"", "type=\"screw\"", "joint \"push\": `type` is \"screw\", expected revolute"),
        (push, "lower=\"0\" upper=\"1\" velocity=\"1\"/><mimic joint=\"turn\"", "joint \"push\": is mimic"),
        ("2 4 6", "2 4 0", "link \"base\", collision, box: `size` is \"2 4 0\", expected positive numbers"),
        ("radius=\"0.5\"", "radius=\"-1\"", "link \"column\", collision, sphere: `radius` is \"-1\""),
        (" length=\"3\"", "", "link \"finger\", collision, cylinder: `length` is missing"),
        (
            "<box size=\"2 4 6\"/>",
            "<cone/>",
            "collision, cone: is unknown, expected box, sphere, cylinder or",
        ),
        ("<box size=\"2 4 6\"/>", "", "link \"base\", collision: has no <geometry> with a solid"),
        ("2 2 -2", "2 0 2", "\"slide.stl\" is flat at scale"),
        (
            "<link name=\"boom\"/>",
            "<x:macro xmlns:x=\"http://www.ros.org/wiki/xacro\"/><link name=\"boom\"/>",
            "URDF: <macro> is of xacro; expand the file first",
        ),
    ];
    for (from, to, expected) in cases {
        let found = changed(from, to);
        assert!(found.contains(expected), "{to}\nfound:    {found}\nexpected: {expected}");
    }
}

#[test]
fn all_faults_are_told_at_once_with_their_lines() {
    let text = ROBOT.replace("2 4 6", "2 4").replace("\"0 0 -2\"", "\"0 0 0\"").replace("0.2", "-0.2");
    let error = read(&text).unwrap_err();
    assert_eq!(
        error.to_string(),
        "line 3, link \"base\", collision, box: `size` is \"2 4\", expected 3 finite \
        numbers of at most 1e6\n\
        line 14, joint \"turn\", axis: `xyz` is \"0 0 0\", expected a direction\n\
        line 18, joint \"push\", limit: `velocity` is -0.2, expected a positive number"
    );
}

#[test]
fn options_that_fit_no_file_are_refused() {
    let of = |options: &UrdfOptions| faults(ROBOT, options).join("\n");
    let base_link = Some("bass");
    assert!(
        of(&UrdfOptions { base_link, ..options() })
            .starts_with("base_link: \"bass\" is not a link, expected")
    );
    let tip_link = Some("tip");
    assert!(of(&UrdfOptions { tip_link, ..options() }).starts_with("tip_link: \"tip\" is not a link"));
    let tip_link = Some("column");
    assert!(of(&UrdfOptions { tip_link, ..options() }).starts_with("robot: no joint moves between \"base\""));
    let between = UrdfOptions { base_link: Some("slide"), tip_link: Some("boom"), ..options() };
    assert_eq!(of(&between), "tip_link: \"boom\" is not below the base, \"slide\"");
    let several = of(&UrdfOptions { tip_link: None, ..options() });
    assert_eq!(several, "tip_link: must be given, because the arm ends in \"finger\", \"lamp\"");
    let late = of(&UrdfOptions { seconds_to_full_speed: f64::NAN, ..options() });
    assert_eq!(late, "seconds_to_full_speed: is NaN, expected a positive number of seconds");
    let missing = UrdfOptions { load_mesh: &|_| Err("no such file".into()), ..options() };
    assert_eq!(of(&missing), "link \"slide\", collision, mesh: \"slide.stl\" cannot be read: no such file");
    let refused = UrdfOptions { load_mesh: UrdfOptions::default().load_mesh, ..options() };
    assert!(of(&refused).contains("`load_mesh`"));
    let bad = UrdfOptions { load_mesh: &|_| Ok(vec![DVec3::NAN]), ..options() };
    assert!(of(&bad).contains("has a point at [NaN, NaN, NaN]"));
    let empty = UrdfOptions { load_mesh: &|_| Ok(Vec::new()), ..options() };
    assert_eq!(Arm::from_urdf(ROBOT, &empty).unwrap().links[2].shapes.len(), 1);
}

#[test]
fn a_robot_without_joints_or_links_is_refused() {
    let default = UrdfOptions::default();
    assert_eq!(faults("<robot/>", &default), ["robot: has no links, expected at least two"]);
    let lone = faults("<robot><link name=\"a\"/></robot>", &default);
    assert_eq!(lone, ["robot: no joint moves between \"a\" and \"any other link\", expected at least one"]);
    let other = faults("<model><link name=\"a\"/></model>", &default);
    assert_eq!(other, ["root element: is <model>, expected <robot>"]);
}

/// As deep and as long as a file may get, without harm to the stack or the run time.
#[test]
fn deep_and_long_files_are_read() {
    let n = 20_000;
    let deep = format!("<robot>{}{}</robot>", "<link name=\"a\">".repeat(n), "</link>".repeat(n));
    assert!(Arm::from_urdf(&deep, &UrdfOptions::default()).is_err());
    let mut long = String::from("<robot><link name=\"l0\"/>\n");
    for i in 0..n {
        long += &format!(
            "<link name=\"l{}\"/><joint name=\"j{i}\" type=\"prismatic\"><parent link=\"l{i}\"/>\
            <child link=\"l{}\"/><limit lower=\"0\" upper=\"1\" velocity=\"1\"/></joint>\n",
            i + 1,
            i + 1
        );
    }
    let arm = Arm::from_urdf(&(long + "</robot>"), &UrdfOptions::default()).unwrap();
    assert_eq!(arm.forward(&vec![1.0; n]).translation().x, n as f64);
}

proptest! {
    #[test]
    fn any_text_is_read_or_refused(text in "\\PC*") {
        let _ = read(&text);
    }

    /// Pieces of the file cut, doubled and exchanged.
    #[test]
    fn damaged_files_are_read_or_refused(
        cuts in proptest::collection::vec((0..ROBOT.len(), 0..ROBOT.len(), 0..4_usize), 1..6)
    ) {
        let mut text = ROBOT.to_owned();
        for (a, b, way) in cuts {
            let (a, b) = (a.min(b).min(text.len()), a.max(b).min(text.len()));
            match way {
                0 => text.replace_range(a..b.min(a + 12), ""),
                1 => text.insert_str(a, &ROBOT[b.min(ROBOT.len())..(b + 9).min(ROBOT.len())]),
                2 => text.insert_str(a, "\" <>&9e-"),
                _ => text.truncate(b.max(a + 1).min(text.len())),
            }
        }
        let _ = read(&text);
    }

    /// Names and numbers replaced by others: well-formed, and mostly nonsense.
    #[test]
    fn senseless_files_are_read_or_refused(
        swaps in proptest::collection::vec((0..60_usize, 0..60_usize), 1..4),
        values in proptest::collection::vec(prop_oneof![
            any::<f64>().prop_map(|x| x.to_string()), Just("1e6 1e6 1e6".into()), Just("1e-300".into())
        ], 4),
    ) {
        let mut parts: Vec<String> = ROBOT.split('"').map(str::to_owned).collect();
        let n_values = parts.len() / 2;
        for (i, (a, b)) in swaps.into_iter().enumerate() {
            let (a, b) = (2 * (a % n_values) + 1, 2 * (b % n_values) + 1);
            parts.swap(a, b);
            if i % 2 == 1 {
                parts[a] = values[i].clone();
            }
        }
        if let Ok(arm) = read(&parts.join("\"")) {
            let values: Vec<f64> = arm.joints.iter().map(|joint| joint.limits.upper).collect();
            prop_assert!(arm.forward(&values).translation().is_finite());
            prop_assert!(arm.is_within_limits(&values));
        }
    }
}
