//! Scans of recorded frames. Here the recordings are simulated; those of real cameras are tested in the crate
//! that reads them.

use crate::common::{Folder, RESULT_FILES, curve, data, timeless};
use crate::ply::Vertices;
use crate::recording::{SCAN, color_at, write_colors, write_recording};
use glam::DVec3;
use serde_json::Value;

fn scan<'a>(args: &[&'a str]) -> Vec<&'a str> {
    [&SCAN, args].concat()
}

#[test]
fn plans_over_the_recorded_views() {
    let folder = Folder::new("recorded");
    write_recording(&folder, 12);
    let result = folder.json(&scan(&["--views", "5", "--json"]));
    assert_eq!((&result["object"], &result["planner"]), (&"rec".into(), &"most-surface".into()));
    assert_eq!((&result["candidates"], &result["views"]), (&12.into(), &5.into()));
    let with_truth = [
        "voxel_coverage",
        "surface_coverage_2mm",
        "reachable_coverage",
        "skill",
        "random_curve",
        "cloud_accuracy_mean_mm",
        "mesh_accuracy_mean_mm",
    ];
    for key in with_truth {
        assert!(result[key].is_null(), "{key} needs the truth");
    }
    assert_eq!(result["steps"][0]["frame"], "frame 0");
    assert!(result["skipped"].is_null() && curve(&result, "hit_voxels").iter().all(|hits| *hits > 0.0));

    assert_eq!(folder.names("out"), RESULT_FILES);
    let steps: Vec<Value> =
        folder.text("out/steps.jsonl").lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let mut views: Vec<u64> = steps.iter().map(|step| step["view"].as_u64().unwrap()).collect();
    views.sort_unstable();
    views.dedup();
    assert!(views.len() == 5 && views[0] == 0, "distinct views, the first one first");
    let map = folder.json(&["map", "info", "out/map.ot", "--json"]);
    assert!(map["occupied_voxels"].as_u64().unwrap() > 300);

    let again = folder.json(&["scan", "--config", "out/config.toml", "--out", "again", "--json"]);
    assert_eq!(timeless(again), timeless(result));
    for file in ["config.toml", "map.ot", "cloud.ply", "mesh.ply", "views.csv"] {
        assert_eq!(folder.bytes(&format!("again/{file}")), folder.bytes(&format!("out/{file}")), "{file}");
    }
}

#[test]
fn what_is_below_the_stated_table_is_not_the_object() {
    let folder = Folder::new("recorded-table");
    write_recording(&folder, 12);
    let lowest = |args: &[&str]| {
        folder.ok(&scan(&[&["--views", "8"], args].concat()));
        let steps = folder.text("out/steps.jsonl");
        let last: Value = serde_json::from_str(steps.lines().last().unwrap()).unwrap();
        last["box_min_m"][2].as_f64().unwrap()
    };
    let whole = lowest(&[]);
    let cut = lowest(&["--table-z-m", "0.03"]);
    assert!(whole < 0.0 && (0.03..0.035).contains(&cut), "{whole} {cut}");
}

#[test]
fn the_order_may_be_the_recorded_one_or_random() {
    let folder = Folder::new("recorded-order");
    write_recording(&folder, 6);
    let views =
        |args: &[&str]| curve(&folder.json(&scan(&[args, &["--views=5", "--json"]].concat())), "view");
    assert_eq!(views(&["--planner", "in-order"]), [0.0, 1.0, 2.0, 3.0, 4.0]);
    assert_eq!(views(&["--planner", "in-order", "--first-view", "4"]), [4.0, 5.0, 0.0, 1.0, 2.0]);
    let random = views(&["--planner", "random", "--seed", "3"]);
    assert_eq!(random, views(&["--planner", "random", "--seed", "3"]));
    assert_ne!(random, views(&["--planner", "random", "--seed", "4"]));
}

#[test]
fn the_truth_measures_the_scan() {
    let folder = Folder::new("recorded-truth");
    write_recording(&folder, 12);
    let options = ["--views", "4", "--truth", "mug.obj", "--unit", "m", "--json"];
    let there = folder.json(&scan(&options));
    for key in ["voxel_coverage", "surface_coverage_1mm", "surface_coverage_5mm", "reachable_coverage"] {
        let curve = curve(&there, key);
        assert!(curve.len() == 4 && curve.is_sorted() && curve[0] > 0.1, "{key}: {curve:?}");
    }
    let millimetres = |key: &str| there["steps"][3][key].as_f64().unwrap();
    let [median, mean, p95] = ["accuracy_median_mm", "accuracy_mean_mm", "accuracy_p95_mm"].map(millimetres);
    assert!(
        median < 0.4 && mean < 0.5 && p95 < 1.0,
        "depth is rounded to a millimetre: {median} {mean} {p95}"
    );
    assert!(there["skill"].is_f64());
    for model in ["cloud", "mesh"] {
        let of = |key: &str| there[format!("{model}_{key}")].as_f64().unwrap();
        assert!(of("accuracy_mean_mm") < 0.6 && of("completeness_5mm") > 0.5, "{model}");
    }
    let steps = folder.text("out/steps.jsonl");
    assert!(steps.contains("\"frame\":\"frame 0\"") && steps.contains("\"accuracy_p95_mm\":"), "{steps}");

    // The same mesh in another place, and the transform to that place.
    folder.write("moved.txt", "0 -1 0 0.3\n1 0 0 -0.2\n0 0 1 0.1\n0 0 0 1\n");
    let moved = ["--views=4", "--truth=moved.obj", "--truth-from-world=moved.txt", "--unit=m", "--json"];
    let moved = folder.json(&scan(&moved));
    let [a, b] = [&there, &moved].map(|result| curve(result, "surface_coverage_2mm")[3]);
    assert!((a - b).abs() < 0.02, "{a} {b}");

    let clairvoyant = folder.json(&scan(&[&options[..], &["--planner", "clairvoyant"]].concat()));
    assert_eq!(clairvoyant["skill"], 1.0);
}

#[test]
fn colour_is_in_cloud_and_mesh() {
    let folder = Folder::new("recorded-color");
    write_recording(&folder, 4);
    let scan = || {
        folder.json(&scan(&["--views", "3", "--planner", "in-order", "--json"]));
        ["cloud.ply", "mesh.ply"].map(|file| Vertices::read(&folder.bytes(&format!("out/{file}"))))
    };
    let plain = scan();
    write_colors(&folder, 4);
    let colored = scan();
    for (plain, colored) in plain.iter().zip(&colored) {
        assert!(plain.colors.is_empty() && colored.columns[6..] == ["red", "green", "blue"]);
        assert!(plain.positions == colored.positions && plain.normals == colored.normals);
    }
    // Colour tells where a point is; that of a vertex is of the point next to it, 4 cells of 2.5 mm away at
    // most.
    for (file, most_off) in [(&colored[0], 1), (&colored[1], 6)] {
        for ((position, normal), color) in file.positions.iter().zip(&file.normals).zip(&file.colors) {
            let expected = color_at(DVec3::from_array(position.map(f64::from)));
            let off = expected.iter().zip(color).map(|(a, b)| a.abs_diff(*b)).max().unwrap();
            assert!(off <= most_off || *color == [0; 3] && *normal == [0.0; 3], "{off} at {position:?}");
        }
    }
    folder.write("rec/color/001.png", [0; 9]);
    let run = folder.run(&SCAN);
    assert!(
        run.code == Some(1) && run.stderr.contains("rec/color/001.png: is not a complete PNG"),
        "{}",
        run.stderr
    );
}

#[test]
fn what_is_left_out_is_told() {
    let folder = Folder::new("recorded-skips");
    write_recording(&folder, 4);
    std::fs::remove_file(folder.path("rec/depth/002.png")).unwrap();
    let text = folder.ok(&scan(&["--views", "2", "--planner", "in-order"]));
    let head = "rec: 3 recorded frames of 160 x 120 pixels\nskipped: the pose of frame 2 (poses.csv, line 4) is left out: ";
    assert!(text.starts_with(head), "{text}");
    assert!(text.contains("\nskipped                1 of the recording\n"), "{text}");
    let run = folder.run(&scan(&["--views", "4"]));
    let why = "error: --views is 4, expected 1 to 3 (the candidates)\nhint: the pose of frame 2 (poses.csv, line 4) is left out: ";
    assert!(run.code == Some(2) && run.stderr.starts_with(why), "{}", run.stderr);
    let run = folder.run(&scan(&["--views", "2", "--json"]));
    assert!(run.code == Some(0) && run.stderr.starts_with("skipped: the pose of frame 2"), "{}", run.stderr);
    let result: Value = serde_json::from_str(&run.stdout).unwrap();
    assert!(result["skipped"][0].as_str().unwrap().contains("depth/ has no image with that number"));
}

#[test]
fn frames_that_show_nothing_in_the_box_are_told() {
    let folder = Folder::new("recorded-blind");
    write_recording(&folder, 4);
    let run = folder.run(&scan(&["--views", "2", "--planner", "in-order", "--box-m=5,5,5,5.2,5.2,5.2"]));
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert!(run.stdout.contains("\nnothing in the box     frame 0, frame 1\n"), "{}", run.stdout);
    let reason = "warning: the frame shows nothing in the object's box: its points lie within ";
    let remedy = "; --box-m is in the coordinates of the poses, in metres\n";
    assert!(run.stderr.starts_with(reason) && run.stderr.ends_with(remedy), "{}", run.stderr);
}

#[test]
fn issue_18_poses_of_other_conventions_are_named_and_can_be_read() {
    let folder = Folder::new("recorded-conventions");
    write_recording(&folder, 6);
    let options = ["--views", "4", "--planner", "in-order", "--box-m=-0.1,-0.1,-0.1,0.1,0.1,0.1", "--json"];
    let hits = |run: &str| curve(&serde_json::from_str(run).unwrap(), "hit_voxels");
    let right = folder.run(&scan(&options));
    assert_eq!((right.code, right.stderr.as_str()), (Some(0), ""));
    let read_wrong = folder.run(&scan(&[&options[..], &["--camera-axes", "opengl"]].concat()));
    let leave_out =
        "warning: the poses look like those of cameras with OpenCV axes: leave out --camera-axes\n";
    assert_eq!(read_wrong.stderr, leave_out);
    // In OpenGL, y and z of the camera point the other way.
    let opengl = |row: &str| {
        let cells = row.split(',').enumerate().map(|(i, cell)| match (i + 3) % 4 {
            1 | 2 if i > 0 => (-cell.parse::<f64>().unwrap()).to_string(),
            _ => cell.to_owned(),
        });
        cells.collect::<Vec<_>>().join(",")
    };
    let poses = folder.text("rec/poses.csv");
    let (header, rows) = poses.split_once('\n').unwrap();
    let turned: Vec<String> = rows.lines().map(opengl).collect();
    folder.write("rec/poses.csv", format!("{header}\n{}\n", turned.join("\n")));
    let wrong = folder.run(&scan(&options));
    assert!(wrong.stderr.ends_with("; try --camera-axes opengl\n"), "{}", wrong.stderr);
    assert_eq!(wrong.stderr.lines().count(), 1, "said once: {}", wrong.stderr);
    let read = folder.run(&scan(&[&options[..], &["--camera-axes", "opengl"]].concat()));
    assert_eq!((read.code, read.stderr.as_str()), (Some(0), ""));
    assert_eq!(hits(&read.stdout), hits(&right.stdout));
    let run = folder.run(&scan(&[&options[..], &["--camera-axes", "blender"]].concat()));
    assert!(
        run.code == Some(2) && run.stderr.contains("expected one of `opencv`, `opengl`, `ros`"),
        "{}",
        run.stderr
    );
}

#[test]
fn equal_scans_give_equal_bytes_for_any_number_of_threads() {
    let folder = Folder::new("recorded-threads");
    write_recording(&folder, 8);
    let run = |threads: &str| {
        let args = ["--views", "3", "--truth", "mug.obj", "--unit", "m", "--json", "--threads", threads];
        let result = timeless(folder.json(&scan(&args))).to_string();
        (result, ["map.ot", "cloud.ply", "mesh.ply"].map(|file| folder.bytes(&format!("out/{file}"))))
    };
    let one = run("1");
    assert!(run("2") == one && run("4") == one);
}

#[test]
fn a_real_bunny_is_measured() {
    let test = "a_real_bunny_is_measured";
    let Some(frames) = data(test, "rgbd/bunny_primesense") else { return };
    let Some(mesh) = data(test, "meshes/stanford/bunny.ply") else { return };
    let folder = Folder::new("recorded-bunny");
    let transform = frames.join("T_mesh_world.txt");
    let [frames, mesh, transform] = [&frames, &mesh, &transform].map(|path| path.to_str().unwrap());
    let args =
        ["scan", "--frames", frames, "--pose-columns", "given", "--truth", mesh, "--unit", "m", "--json"];
    let args = [&args[..], &["--truth-from-world", transform, "--views", "4", "--out", "out"]].concat();
    let run = folder.run(&args);
    assert!(run.stderr.starts_with("note: the rotations in poses.csv have scale or shear"), "{}", run.stderr);
    let result: Value = serde_json::from_str(&run.stdout).unwrap();
    let coverage = curve(&result, "surface_coverage_2mm");
    println!(
        "{coverage:?} {} {}",
        result["steps"][3]["accuracy_median_mm"], result["cloud_accuracy_median_mm"]
    );
    // Measured: 0.60, 1.09 mm and 1.03 mm.
    assert!(coverage[3] > 0.58, "{coverage:?}");
    assert!(result["steps"][3]["accuracy_median_mm"].as_f64().unwrap() < 1.1, "{}", result["steps"][3]);
    assert!(result["cloud_accuracy_median_mm"].as_f64().unwrap() < 1.1, "{result}");
    let colors = Vertices::read(&folder.bytes("out/cloud.ply")).colors;
    assert!(
        colors.iter().filter(|color| color.iter().all(|value| *value > 100)).count() > 9 * colors.len() / 10
    );
}

#[test]
fn a_scan_that_finds_no_object_says_how_to_go_on() {
    let folder = Folder::new("recorded-nothing");
    write_recording(&folder, 4);
    let run = folder.run(&scan(&["--table-z-m", "10"]));
    assert_eq!(run.code, Some(1), "{}", run.stderr);
    for part in [
        "note: out holds the results so far; --force replaces them\n",
        "error: cloud and mesh: the first frame shows no object above the table",
        "hint: set --first-view to begin with another frame; ",
        "--table-z-m states where the table is",
    ] {
        assert!(run.stderr.contains(part), "{part:?} in {}", run.stderr);
    }
    assert!(!run.stderr.contains("live"), "{}", run.stderr);
}
