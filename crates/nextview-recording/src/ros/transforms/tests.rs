use super::{TransformError, TransformTree};
use glam::{DQuat, DVec3};
use nextview::geometry::Pose;
use proptest::prelude::*;

fn pose(seed: f64) -> Pose {
    let turn = DQuat::from_rotation_x(seed) * DQuat::from_rotation_z(1.3 * seed);
    Pose::new(turn, DVec3::new(seed, -0.5 * seed, 0.2)).unwrap()
}

fn near(a: Pose, b: Pose) -> bool {
    a.translation().distance(b.translation()) < 1e-12 && a.rotation().dot(b.rotation()).abs() > 1.0 - 1e-12
}

/// `map` with the arm `base`, `flange`, `camera`, and a separate `marker` in `base`.
fn robot() -> TransformTree {
    let mut tree = TransformTree::new(10.0);
    tree.insert_static("/map", "base", pose(0.3)).unwrap();
    tree.insert("base", "flange", 7.0, pose(1.0)).unwrap();
    tree.insert_static("flange", "camera", pose(0.7)).unwrap();
    tree.insert_static("base", "marker", pose(-0.4)).unwrap();
    tree
}

#[test]
fn frames_are_chained_up_and_down() {
    let tree = robot();
    assert!(near(tree.lookup("map", "camera", 7.0).unwrap(), pose(0.3) * pose(1.0) * pose(0.7)));
    let sideways = tree.lookup("marker", "/camera", 7.0).unwrap();
    assert!(near(sideways, pose(-0.4).inverse() * pose(1.0) * pose(0.7)));
    assert!(near(tree.lookup("camera", "camera", 99.0).unwrap(), Pose::IDENTITY));
    assert!(near(tree.lookup("marker", "map", 99.0).unwrap(), (pose(0.3) * pose(-0.4)).inverse()));
    assert_eq!((tree.root_of("camera").unwrap(), tree.root_of("map").unwrap()), ("map", "map"));
    assert_eq!(tree.frames(), ["base", "camera", "flange", "map", "marker"]);
}

#[test]
fn what_is_not_known_is_said() {
    let mut tree = robot();
    let error = |tree: &TransformTree, to, from, time| tree.lookup(to, from, time).unwrap_err().to_string();
    let unknown = error(&tree, "map", "lens", 7.0);
    assert_eq!(
        unknown,
        "no transform names the frame 'lens', expected one of base, camera, flange, map, marker"
    );
    assert!(
        error(&tree, "map", "camera", 7.5)
            .contains("known only until 7.000 s, 0.500 s before the requested time")
    );
    assert!(
        error(&tree, "map", "camera", 6.5)
            .contains("known only from 7.000 s, 0.500 s after the requested time")
    );
    tree.insert("odom", "rover", 1.0, pose(1.0)).unwrap();
    assert_eq!(
        error(&tree, "odom", "camera", 7.0),
        "nothing connects 'camera', a frame of the tree of 'map', to 'odom', one of the tree of 'odom'"
    );
    assert!(error(&TransformTree::new(1.0), "a", "b", 0.0).ends_with("there are none"));
}

#[test]
fn what_cannot_be_is_refused_and_changes_nothing() {
    let mut tree = robot();
    let before = format!("{tree:?}");
    let refused = [
        tree.insert("map", "flange", 7.0, pose(0.0)),
        tree.insert_static("base", "flange", pose(0.0)),
        tree.insert("flange", "camera", 7.0, pose(0.0)),
        tree.insert("camera", "map", 7.0, pose(0.0)),
        tree.insert_static("map", "map", pose(0.0)),
        tree.insert("", "x", 7.0, pose(0.0)),
        tree.insert("map", "x", f64::NAN, pose(0.0)),
        tree.insert("base", "flange", -3.1, pose(0.0)),
    ];
    let expected = [
        "'flange' has the parent 'map', expected 'base' as before",
        "'flange' is published both as static and as moving",
        "'camera' is published both as static and as moving",
        "'map' in 'camera' closes a loop",
        "'map' in 'map' closes a loop",
        "a frame has no name",
        "the time is NaN",
        "the clock ran backwards: 'flange' was at 7.000 s and is at -3.100 s now",
    ];
    for (refused, expected) in refused.into_iter().zip(expected) {
        let error = refused.unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
    assert_eq!(format!("{tree:?}"), before);
}

#[test]
fn what_is_old_is_forgotten() {
    let mut tree = TransformTree::new(2.0);
    for i in 0..100_000 {
        tree.insert("base", "flange", 0.03 * i as f64, pose(i as f64)).unwrap();
    }
    assert!(format!("{tree:?}").matches("translation").count() < 70);
    assert!(tree.lookup("base", "flange", 0.03 * 99_990.0).is_ok());
    assert!(matches!(tree.lookup("base", "flange", 5.0), Err(TransformError::Before { .. })));
}

proptest! {
    /// For any input: no panic, no cycle, and every frame has a root.
    #[test]
    fn never_panics(inserts in prop::collection::vec((0..6_u8, 0..6_u8, -20.0..20.0_f64, any::<bool>()), 0..60), time in -20.0..20.0_f64) {
        let mut tree = TransformTree::new(5.0);
        let name = |i: u8| ["", "a", "/b", "c", "d", "e"][i as usize];
        for (parent, child, time, is_static) in inserts {
            let _ = match is_static {
                true => tree.insert_static(name(parent), name(child), pose(time)),
                false => tree.insert(name(parent), name(child), time, pose(time)),
            };
        }
        for (a, b) in (0..6).flat_map(|a| (0..6).map(move |b| (a, b))) {
            if let (Ok(there), Ok(back)) = (tree.lookup(name(a), name(b), time), tree.lookup(name(b), name(a), time)) {
                prop_assert!((there * back).translation().length() < 1e-9);
            }
            let _ = tree.root_of(name(a));
        }
    }
}
