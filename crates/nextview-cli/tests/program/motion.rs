//! Trajectories between views, and views that a robot reaches.

use crate::common::{Folder, small, timeless};
use crate::recording::{SCAN, write_recording};
use serde_json::Value;

/// The rows of a CSV file without its header.
fn rows(text: &str) -> Vec<Vec<f64>> {
    text.lines().skip(1).map(|line| line.split(',').map(|field| field.parse().unwrap()).collect()).collect()
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

#[test]
fn every_view_is_reached_by_waypoints() {
    let folder = Folder::new("motion-ways");
    folder.write("c.toml", "[motion]\nspeed_m_per_s = 0.1\nclearance_m = 0.05\n");
    let result = folder.json(&small(&["--views=4", "--config=c.toml", "--baselines=off", "--json"]));
    let (views, points) = (rows(&folder.text("out/views.csv")), rows(&folder.text("out/waypoints.csv")));
    let steps: Vec<Value> =
        folder.text("out/steps.jsonl").lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let (mut length, mut time) = (0.0, 0.0);
    for (i, step) in steps.iter().enumerate() {
        let way: Vec<&Vec<f64>> = points.iter().filter(|row| row[0] == (i + 1) as f64).collect();
        let (first, last) = (way[0], way[way.len() - 1]);
        assert_eq!((first[1], &last[2..]), (0.0, &views[i][2..]), "from rest, to the view");
        assert_eq!(&first[2..], &views[i.saturating_sub(1)][2..], "from the view before");
        for pair in way.windows(2) {
            let (moved, took) = (distance(&pair[0][2..5], &pair[1][2..5]), pair[1][1] - pair[0][1]);
            assert!(took > 0.0 && moved <= 0.1 * took + 1e-9);
            length += moved;
        }
        time += last[1];
        assert!((step["trajectory_length_m"].as_f64().unwrap() - length).abs() < 1e-9);
        assert!((step["trajectory_time_s"].as_f64().unwrap() - time).abs() < 1e-9);
        assert!(length >= step["path_length_m"].as_f64().unwrap() - 1e-9);
    }
    assert_eq!(
        (&steps[3]["trajectory_length_m"], &steps[3]["trajectory_time_s"]),
        (&result["trajectory_length_m"], &result["trajectory_time_s"])
    );
    assert!(folder.text("out/config.toml").contains("speed_m_per_s = 0.1"));
}

#[test]
fn candidates_out_of_reach_are_dropped() {
    let folder = Folder::new("motion-reach");
    let reach = "--reach=0.3,0,0.1,0.35";
    let text = folder.ok(&small(&["--views=2", reach]));
    let (_, after) = text.split_once("within reach: ").unwrap();
    let n: usize = after.split(' ').next().unwrap().parse().unwrap();
    assert!(after.starts_with(&format!("{n} of 20 candidates\n")) && (2..20).contains(&n), "{after}");
    assert!(text.contains(&format!("{n} candidate views")) && text.contains(&format!("2 of {n} candidates")));
    for row in rows(&folder.text("out/views.csv")) {
        assert!(distance(&row[2..5], &[0.3, 0.0, 0.1]) <= 0.35);
    }
    let run = folder.run(&["scan", "--config", "out/config.toml", "--out", "again", "--json"]);
    let [again, first] = [&run.stdout, &folder.run(&small(&["--views=2", reach, "--json"])).stdout]
        .map(|json| timeless(serde_json::from_str(json).unwrap()));
    assert_eq!(again, first, "{}", run.stderr);

    folder.write(
        "c.toml",
        "[reach]\nforbidden_boxes_m = [[-9, -9, -9, 0, 9, 9]]\n[object_box]\nrule = \"grows\"\n",
    );
    let args = ["--views=4", "--voxel-size-m=0.01", "--baselines=off", "--out=grows"];
    folder.ok(&[&["scan", "builtin:mug", "--candidates=60", "--config=c.toml"], &args[..]].concat());
    let views = rows(&folder.text("grows/views.csv").replace(",,", ",0,"));
    assert!(views.len() > 1 && views.iter().all(|row| row[2] > 0.0), "where the candidates move along, too");
}

#[test]
fn reach_must_leave_candidates() {
    let folder = Folder::new("motion-no-reach");
    let refused = |args: &[&str], parts: &[&str]| {
        let run = folder.run(args);
        assert_eq!(run.code, Some(2), "{}", run.stderr);
        assert!(parts.iter().all(|part| run.stderr.contains(part)), "{}", run.stderr);
    };
    refused(
        &small(&["--reach=9,9,9,1"]),
        &["none of the 20 view candidates is within reach", "hint: --reach"],
    );
    refused(
        &small(&["--reach=0.3,0,0.1,0.35", "--first-view=19"]),
        &["--first-view is 19", "within reach count"],
    );
    refused(&small(&["--reach=0,0,0"]), &["3 numbers, expected 4: x,y,z,r"]);
    refused(&small(&["--reach=0,0,0,-1"]), &["the radius is -1"]);
}

#[test]
fn recorded_frames_out_of_reach_are_dropped() {
    let folder = Folder::new("motion-recorded");
    write_recording(&folder, 10);
    let scan = |args: &[&'static str]| [&SCAN, args].concat();
    let all = folder.json(&scan(&["--views=10", "--planner=in-order", "--json"]));
    let positions = rows(&folder.text("out/views.csv"));
    let result = folder.run(&scan(&["--views=2", "--planner=in-order", "--reach=1,0,0,1", "--json"]));
    let result: Value = serde_json::from_str(&result.stdout).unwrap();
    let near = |i: &usize| distance(&positions[*i][2..5], &[1.0, 0.0, 0.0]) <= 1.0;
    let left: Vec<usize> = (0..10).filter(near).collect();
    assert_eq!(result["candidates"], left.len());
    let names: Vec<&Value> = left[..2].iter().map(|i| &all["steps"][*i]["frame"]).collect();
    let taken: Vec<&Value> = result["steps"].as_array().unwrap().iter().map(|step| &step["frame"]).collect();
    assert_eq!(taken, names);
}
