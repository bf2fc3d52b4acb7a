//! Objects that are turned between two scans.

use crate::common::{Folder, small};
use nextview_sim::builtin;
use serde_json::Value;

/// The arguments for a scan of a bracket on a table: the first placement.
const BRACKET: [&str; 9] = [
    "scan",
    "builtin:bracket",
    "--candidates=100",
    "--voxel-size-m=0.005",
    "--table=known",
    "--views=6",
    "--baselines=off",
    "--json",
    "--noise=d435i",
];

#[test]
fn a_turn_shows_the_underside_and_makes_one_model() {
    let folder = Folder::new("turned");
    let record =
        |dir: &str| -> Value { serde_json::from_str(&folder.text(&format!("{dir}/record.json"))).unwrap() };
    let after = folder.json(&[&BRACKET[..], &["--flips=1", "--out=out"]].concat());
    let before = record("out-placement-1");
    assert_eq!(after, record("out"));
    let next = &before["next_placement"];
    assert!(next["down"][2].as_f64().unwrap() > 0.5, "the underside comes up: {next}");
    let turn = &after["turn"];
    assert!(turn["refusal"].is_null() && turn["error_mm"].as_f64().unwrap() < 0.5, "{turn}");
    let complete = |record: &Value| record["cloud_completeness_2mm"].as_f64().unwrap();
    assert!(complete(&after) > complete(&before) + 0.05, "{} {}", complete(&before), complete(&after));
    assert!(after["cloud_precision_2mm"].as_f64().unwrap() > 0.99);
    // All frames of both placements exist, and the page requests a turn if one is wanted.
    let n_frames = folder.names("out/frames/depth").len();
    assert_eq!(n_frames as u64, before["views"].as_u64().unwrap() + after["views"].as_u64().unwrap());
    let page = folder.text("out-placement-1/report.html");
    assert!(page.contains("To see more, turn the object") && page.contains("requested placement"));
    // The frames of a turned object can be exported, and scanned again.
    folder.ok(&["export", "out", "--to", "pcd", "--out", "pcd"]);
    let again = folder.json(&[
        "scan",
        "--frames=out/frames",
        "--json",
        "--out=again",
        "--planner=in-order",
        "--views=12",
    ]);
    assert_eq!(again["views"].as_u64().unwrap(), n_frames as u64);

    // An object of another shape cannot be this one, turned.
    let mesh = builtin::by_name("teapot").unwrap();
    let vertices = mesh.vertices().iter().map(|v| format!("v {} {} {}\n", v.x, v.y, v.z));
    let faces = mesh.triangles().iter().map(|t| format!("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1));
    folder.write("other.obj", vertices.chain(faces).collect::<String>());
    let wrong =
        [&["scan", "other.obj", "--unit=m"], &BRACKET[2..], &["--after=out-placement-1", "--out=wrong"]];
    let wrong = folder.json(&wrong.concat());
    assert!(wrong["turn"]["refusal"].is_string(), "{}", wrong["turn"]);
    assert_eq!(folder.names("wrong/frames/depth").len() as u64, wrong["views"].as_u64().unwrap());

    let third = folder.run(&[&BRACKET[..], &["--after=out", "--out=third"]].concat());
    assert_eq!(third.code, Some(1));
    assert!(third.stderr.contains("cannot be continued itself"), "{}", third.stderr);

    // Without one of its frames, the first placement would be another object.
    let frame = folder.names("out-placement-1/frames/depth").remove(0);
    std::fs::remove_file(folder.path(&format!("out-placement-1/frames/depth/{frame}"))).unwrap();
    let gone = folder.run(&[&BRACKET[..], &["--after=out-placement-1", "--out=gone"]].concat());
    assert_eq!(gone.code, Some(1));
    assert!(gone.stderr.contains("out-placement-1/frames: a frame cannot be read: "), "{}", gone.stderr);
}

#[test]
fn what_cannot_be_turned_is_named() {
    let folder = Folder::new("turned-faults");
    let refused = |args: &[&str], code: i32, part: &str| {
        let run = folder.run(&small(args));
        assert_eq!(run.code, Some(code), "{args:?}: {}", run.stderr);
        assert!(run.stderr.contains(part), "{part:?} in {}", run.stderr);
        assert!(!folder.path("out").exists(), "{args:?} left something");
    };
    refused(&["--flips=1"], 2, "hint: --table fit lets the scan find its table");
    refused(&["--flips=2", "--table=known"], 2, "2 is not in 0..=1");
    refused(&["--flips=1", "--after=x", "--table=known"], 2, "cannot be used with");
    refused(&["--after=no"], 1, "no: holds no results of a scan");
    folder.run(&small(&["--views=2", "--baselines=off"]));
    std::fs::rename(folder.path("out"), folder.path("floating")).unwrap();
    refused(&["--after=floating"], 1, "requests no other placement");
}
