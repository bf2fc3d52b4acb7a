use crate::common::{Folder, RESULT_FILES, curve, data, small, timeless};
use crate::ply::Vertices;
use nextview_sim::mesh;
use serde_json::Value;

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

/// Whether values are in 0..=1 and never decrease.
fn is_coverage(values: &[f64]) -> bool {
    values.iter().all(|v| (0.0..=1.0).contains(v)) && values.is_sorted()
}

#[test]
fn writes_all_that_the_issue_lists() {
    let folder = Folder::new("scan-files");
    let result = folder.json(&small(&["--views", "3", "--json"]));
    assert_eq!(result["object"], "mug");
    assert_eq!(result["planner"], "most-surface");
    assert_eq!(result["profile"], "default");
    assert_eq!(result["seed"], 0);
    assert_eq!(result["views"], 3);
    assert_eq!(result["stop_reason"], "view-limit");
    for key in ["voxel_coverage", "surface_coverage_2mm", "reachable_coverage"] {
        let curve = curve(&result, key);
        assert!(curve.len() == 3 && is_coverage(&curve) && curve[0] > 0.1, "{key}: {curve:?}");
    }
    assert_eq!(curve(&result, "plan_time_ms").len(), 3);
    assert_eq!(result["reachable_coverage"], result["steps"][2]["reachable_coverage"]);
    assert!((-3.0..=1.5).contains(&result["skill"].as_f64().unwrap()));
    assert!(result["path_length_m"].as_f64().unwrap() > 0.1);
    assert!(!cfg!(target_os = "linux") || result["peak_memory_mb"].as_f64().unwrap() > 1.0);

    assert_eq!(folder.names("."), ["out/"]);
    assert_eq!(folder.names("out"), RESULT_FILES);
    check_steps(&folder.text("out/steps.jsonl"), &result);
    assert_eq!(folder.text("out/views.csv").lines().count(), 4);
    check_maps(&folder);
    check_models(&folder);
    check_quality(&result);
    assert!(folder.text("out/report.html").contains("<title>mug"));
}

fn check_steps(steps: &str, result: &Value) {
    let steps: Vec<Value> = steps.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(steps.len(), 3);
    for (i, step) in steps.iter().enumerate() {
        assert_eq!(step["step"], i + 1);
        assert_eq!(*step, result["steps"][i]);
        assert_eq!(step["score"].is_null(), i == 0, "only the first view is given");
    }
}

fn check_maps(folder: &Folder) {
    let [ot, bt] = ["out/map.ot", "out/map.bt"].map(|map| folder.json(&["map", "info", map, "--json"]));
    for map in [&ot, &bt] {
        assert_eq!((&map["kind"], map["voxel_size_m"].as_f64()), (&"OcTree".into(), Some(0.01)));
    }
    assert_eq!(ot["measured_voxels"], bt["measured_voxels"]);
    assert!(ot["occupied_voxels"].as_u64().unwrap() > 300);
    assert!(ot["free_voxels"].as_u64() > ot["occupied_voxels"].as_u64());
}

fn check_models(folder: &Folder) {
    let mesh = mesh::load(&folder.path("out/mesh.ply")).unwrap();
    assert!((0.1..0.25).contains(&mesh.longest_side()), "a mug in metres: {}", mesh.longest_side());
    for file in ["cloud.ply", "mesh.ply"] {
        let vertices = Vertices::read(&folder.bytes(&format!("out/{file}")));
        assert_eq!(vertices.columns, ["x", "y", "z", "nx", "ny", "nz"], "a simulated camera sees no colour");
        let n_points = vertices.positions.len();
        assert!((1_000..100_000).contains(&n_points), "{file}: {n_points}");
        let length = |n: &[f32; 3]| n.iter().map(|x| x * x).sum::<f32>().sqrt();
        let [none, unit] =
            [0.0, 1.0].map(|l| vertices.normals.iter().filter(|n| (length(n) - l).abs() < 1e-5).count());
        assert!(none + unit == n_points && unit as f64 > 0.9 * n_points as f64, "{file}: {none}, {unit}");
    }
}

fn check_quality(result: &Value) {
    for model in ["cloud", "mesh"] {
        let of = |key: &str| result[format!("{model}_{key}")].as_f64().unwrap();
        let [mean, median, p95] = ["accuracy_mean_mm", "accuracy_median_mm", "accuracy_p95_mm"].map(of);
        assert!(mean < 0.6 && median < 0.4 && median < p95 && p95 < 3.0, "{model}: {mean} {median} {p95}");
        let complete = ["completeness_1mm", "completeness_2mm", "completeness_5mm"].map(of);
        assert!(is_coverage(&complete) && complete[2] > 0.4, "{model}: {complete:?}");
        assert!((0.0..50.0).contains(&of("completeness_mean_mm")));
    }
}

#[test]
fn wrong_poses_show_in_the_final_model() {
    let folder = Folder::new("scan-quality");
    let accuracy = |args: &[&str]| {
        let args = [&["--views", "3", "--baselines", "off", "--json"], args].concat();
        folder.json(&small(&args))["cloud_accuracy_mean_mm"].as_f64().unwrap()
    };
    let [right, wrong] = [accuracy(&[]), accuracy(&["--pose-error-mm", "10"])];
    assert!(right < 0.1 && (2.0..20.0).contains(&wrong), "{right} {wrong}");
    // The cloud holds the table's points, but they count for nothing.
    let on_table = accuracy(&["--table", "known"]);
    assert!(on_table < 0.1, "{on_table}");
}

#[test]
fn results_feed_the_next_scan() {
    let folder = Folder::new("scan-again");
    let first = folder.json(&small(&["--views", "3", "--json"]));
    let again = folder.json(&["scan", "--config", "out/config.toml", "--out", "again", "--json"]);
    assert_eq!(timeless(again), timeless(first.clone()));
    assert_eq!(folder.bytes("again/config.toml"), folder.bytes("out/config.toml"));

    let args = ["scan", "builtin:mug", "--voxel-size-m=0.01", "--view-space=out/views.csv", "--out=third"];
    let same_views = folder.json(&[&args[..], &["--json"]].concat());
    assert_eq!(
        (&same_views["candidates"], &same_views["views"]),
        (&3.into(), &3.into()),
        "no more than there are"
    );
    assert_eq!(curve(&same_views, "voxel_coverage")[0], curve(&first, "voxel_coverage")[0]);
    assert!(folder.text("third/config.toml").contains("view_space = \"out/views.csv\""));
    folder.json(&small(&["--views", "2", "--json"]));
    assert_eq!(folder.names("out"), RESULT_FILES, "results are replaced");
}

#[test]
fn options_override_the_configuration() {
    let folder = Folder::new("scan-override");
    folder.write("c.toml", "object = \"builtin:mug\"\nviews = 4\nseed = 7\nbaselines = false\n");
    let args = ["--config", "c.toml", "--views", "1", "--planner", "random", "--json"];
    let result = folder.json(&small(&args));
    assert_eq!(
        (&result["views"], &result["seed"], &result["planner"]),
        (&1.into(), &7.into(), &"random".into())
    );
}

#[test]
fn every_planner_scans() {
    let folder = Folder::new("scan-planners");
    for planner in ["local", "random", "clairvoyant"] {
        let result = folder.json(&small(&["--views", "3", "--planner", planner, "--json"]));
        assert_eq!((&result["planner"], &result["views"]), (&planner.into(), &3.into()));
        if planner == "clairvoyant" {
            assert_eq!(result["skill"], 1.0);
            assert_eq!(curve(&result, "reachable_coverage"), numbers(&result["clairvoyant_curve"]));
        }
    }
}

#[test]
fn every_gain_scans_and_plans() {
    let folder = Folder::new("scan-gains");
    folder.ok(&["views", "--rule", "sphere", "--count", "30", "--size-m", "0.12", "--out", "v.csv"]);
    for planner in [
        "apora",
        "rse",
        "rear-side-voxel",
        "occlusion-aware",
        "unobserved-voxel",
        "average-entropy",
        "krainin",
        "area-factor",
        "potthast",
        "frontier-tour",
        "pb-nbv",
        "receding-horizon",
        "nbv-regression",
        "pc-nbv",
        "batch",
    ] {
        let args = ["--views", "3", "--planner", planner, "--baselines", "off", "--json"];
        let result = folder.json(&small(&args));
        assert_eq!((&result["planner"], &result["views"]), (&planner.into(), &3.into()));
        let args = ["plan", "--map", "out/map.ot", "--views", "v.csv", "--planner", planner, "--json"];
        let plan = folder.json(&args);
        assert!(plan["planner"] == planner && plan["view"].is_u64(), "{plan}");
    }
}

#[test]
fn moving_may_cost() {
    let folder = Folder::new("scan-theta");
    let views = |planner: &str, theta: &str| {
        let args = ["--views", "3", "--planner", planner, "--theta", theta, "--baselines", "off", "--json"];
        let ids = curve(&folder.json(&small(&args)), "view");
        assert_eq!(folder.text("out/config.toml").matches(&format!("theta = {theta}")).count(), 4);
        ids
    };
    for planner in ["max-flow", "local", "unobserved-voxel"] {
        assert_ne!(views(planner, "0.0"), views(planner, "1.0"), "{planner}");
    }
}

#[test]
fn every_view_space_and_profile_scans() {
    let folder = Folder::new("scan-view-spaces");
    for rule in ["sphere", "hemisphere", "ring"] {
        folder.json(&small(&["--views", "2", "--view-space", rule, "--baselines", "off", "--json"]));
        let heights = folder.text("out/steps.jsonl");
        assert_eq!(heights.lines().count(), 2);
    }
    let result = folder.json(&small(&["--views", "2", "--profile", "paper", "--baselines", "off", "--json"]));
    assert_eq!(result["profile"], "paper");
    assert!(folder.text("out/config.toml").contains("background = \"ignore\""));
    for key in ["reachable_coverage", "random_curve", "clairvoyant_curve", "skill"] {
        assert!(result[key].is_null(), "{key} needs baselines");
    }
}

#[test]
fn planning_may_know_less_and_begin_coarser() {
    let folder = Folder::new("scan-unknown");
    let command =
        "scan builtin:mug --views 4 --candidates 60 --voxel-size-m 0.005 --baselines off --json --out out";
    let options = ["--box", "grows", "--table", "fit", "--multi-resolution", "on"];
    let args: Vec<&str> = command.split(' ').chain(options).collect();
    folder.json(&args);
    let config = folder.text("out/config.toml");
    for line in ["rule = \"grows\"", "table = \"fit\"", "enabled = true"] {
        assert!(config.contains(line), "{config}");
    }
    let steps = folder.text("out/steps.jsonl");
    let first: Value = serde_json::from_str(steps.lines().next().unwrap()).unwrap();
    assert_eq!(first["voxel_size_m"].as_f64(), Some(0.01));
    assert!(first["box_min_m"].is_array() && first["table_normal"].is_array());
    assert!(first["view"].is_null(), "the first view is no candidate");
}

/// Frames with poses that are off by 2 mm stay near them. Little of each new frame of a foam brick was seen
/// before, and the other sides of the brick must not be aligned to the known ones, 3 cm away.
#[test]
fn registration_leaves_frames_near_where_they_nearly_are() {
    let test = "registration_leaves_frames_near_where_they_nearly_are";
    let Some(brick) = data(test, "meshes/ycb/ycb_061_foam_brick.ply") else { return };
    let folder = Folder::new("scan-brick");
    let args =
        ["scan", brick.to_str().unwrap(), "--unit", "m", "--view-space", "hemisphere", "--table", "known"];
    let noise = ["--pose-error-mm", "2", "--pose-error-deg", "0.2", "--register", "on"];
    let small = ["--candidates", "300", "--views", "4", "--baselines", "off", "--json", "--out", "out"];
    let record = folder.json(&[args.as_slice(), &noise, &small].concat());
    let misplaced = curve(&record, "misplaced_mm");
    assert!(misplaced.len() == 4 && misplaced.iter().all(|error| *error < 7.0), "{misplaced:?}");
}

#[test]
fn wrong_poses_are_corrected_on_request() {
    let folder = Folder::new("scan-register");
    let scan = |options: &[&str]| -> Vec<Value> {
        let args = ["--views", "3", "--baselines", "off", "--pose-error-mm", "10", "--pose-error-deg", "1"];
        folder.ok(&small(&[&args, options].concat()));
        folder.text("out/steps.jsonl").lines().map(|line| serde_json::from_str(line).unwrap()).collect()
    };
    let plain = scan(&[]);
    assert!(
        plain.iter().all(|step| step.get("registration_verdict").is_none() && step["misplaced_mm"].is_f64())
    );
    let config = folder.text("out/config.toml");
    assert!(config.contains("[registration]\nenabled = false\n"), "{config}");

    let steps = scan(&["--register", "on", "--min-overlap", "0.5"]);
    assert!(steps[0].get("registration_verdict").is_none(), "there is nothing to align the first image to");
    for step in &steps[1..] {
        let found = |key: &str| &step[format!("registration_{key}")];
        assert_eq!(found("accepted") == true, found("verdict") == "aligned", "{step}");
        for key in
            ["residual_before_mm", "residual_after_mm", "overlap", "moved_mm", "turned_deg", "stiffness"]
        {
            assert!(found(key).as_f64().is_some_and(|value| value >= 0.0), "{key}: {step}");
        }
    }
    let config = folder.text("out/config.toml");
    assert!(
        config.contains("min_overlap = 0.5\n") && config.contains("[registration]\nenabled = true\n"),
        "{config}"
    );
    let again = folder.text("out/steps.jsonl");
    folder.ok(&["scan", "--config", "out/config.toml", "--out", "again"]);
    let without_times = |text: &str| -> Vec<Value> {
        text.lines().map(|line| timeless(serde_json::from_str(line).unwrap())).collect()
    };
    assert_eq!(without_times(&folder.text("again/steps.jsonl")), without_times(&again));
}

#[test]
fn tells_why_it_stopped() {
    let folder = Folder::new("scan-stops");
    let nothing = folder.json(&small(&["--views", "20", "--planner", "clairvoyant", "--json"]));
    assert_eq!(nothing["stop_reason"], "nothing-to-gain");
    let n = nothing["views"].as_u64().unwrap() as usize;
    assert!(n < 20 && curve(&nothing, "voxel_coverage").len() == n);
    assert_eq!(nothing["reachable_coverage"], 1.0);

    folder.write("c.toml", "[stop]\nentropy_share = 0.96\n");
    let args = ["--config", "c.toml", "--baselines", "off", "--json"];
    let converged = folder.json(&small(&args));
    assert_eq!(converged["stop_reason"], "converged");
    assert!(converged["views"].as_u64().unwrap() < 10);
}

#[test]
fn prints_a_line_per_view_and_a_summary() {
    let folder = Folder::new("scan-text");
    let text = folder.ok(&small(&["--views", "2"]));
    let lines: Vec<&str> = text.lines().collect();
    assert!(lines[0].starts_with("mug: 158 x 106 x 125 mm, ") && lines[0].ends_with(" triangles"), "{text}");
    assert_eq!(lines[1], "planner most-surface, profile default, 20 candidate views, voxels of 10 mm");
    let head: Vec<&str> = lines[3].split_whitespace().collect();
    assert_eq!(head, ["step", "view", "reachable", "surface", "new", "voxels", "planning", "path"]);
    assert!(lines[4].starts_with("   1       0  ") && lines[5].starts_with("   2  "));
    assert_eq!(lines[6], "");
    assert!(text.contains("\nstopped because        the view limit was reached\n"), "{text}");
    assert!(text.ends_with("\nresults in out (open report.html there)\n"), "{text}");
}

#[test]
fn an_object_from_a_file_keeps_its_size() {
    let folder = Folder::new("scan-file");
    let tetrahedron = "v 0 0 0\nv 100 0 0\nv 0 80 0\nv 0 0 60\nf 1 2 3\nf 1 2 4\nf 1 3 4\nf 2 3 4\n";
    folder.write("part.obj", tetrahedron);
    let text = folder.ok(&["scan", "part.obj", "--candidates", "9", "--views", "2", "--baselines", "off"]);
    assert!(
        text.starts_with("part: 100 x 80 x 60 mm, 4 triangles\nnote: 1 unit of the file is 0.001 m"),
        "{text}"
    );
    assert!(text.contains("; set --unit to be sure\n"), "{text}");
    assert_eq!(folder.names("."), ["part.obj", "scan-part-most-surface/"], "the default folder");
    let args = ["--candidates", "9", "--views", "1", "--size-m", "0.2", "--baselines", "off", "--out", "out"];
    let text = folder.ok(&[&["scan", "part.obj"], args.as_slice()].concat());
    assert!(text.starts_with("part: 200 x 160 x 120 mm, 4 triangles\nplanner"), "{text}");
}

#[test]
fn a_random_object_is_named_by_its_seed() {
    let folder = Folder::new("scan-random-object");
    let args = ["--candidates", "9", "--views", "2", "--voxel-size-m", "0.02", "--baselines", "off"];
    let text = folder.ok(&[&["scan", "builtin:random-17"], args.as_slice()].concat());
    assert!(text.starts_with("random-17: "), "{text}");
    let [out] = &folder.names(".")[..] else { panic!("one folder") };
    assert!(out.starts_with("scan-random-17-"), "{out}");
    assert!(folder.text(&format!("{out}config.toml")).contains("object = \"builtin:random-17\"\n"));
}

#[test]
fn a_new_folder_may_lie_in_new_folders_and_keeps_what_is_not_its_own() {
    let folder = Folder::new("scan-folders");
    let args = ["scan", "builtin:mug", "--candidates", "5", "--views", "1", "--voxel-size-m", "0.02"];
    let into = |dir: &str| folder.ok(&[args.as_slice(), &["--baselines", "off", "--out", dir]].concat());
    into("a/b/c");
    assert_eq!((folder.names("a"), folder.names("a/b")), (vec!["b/".to_owned()], vec!["c/".to_owned()]));
    folder.write("a/b/notes.txt", "mine");
    into("a/b");
    assert_eq!(folder.names("a/b").len(), 2 + RESULT_FILES.len());
    assert_eq!(folder.text("a/b/notes.txt"), "mine");
    into(".");
    assert_eq!(folder.names(".").len(), 1 + RESULT_FILES.len());
}

/// A reader that stops after the first lines must not prevent the results.
#[cfg(unix)]
#[test]
fn a_closed_stdout_is_no_failure() {
    let folder = Folder::new("scan-pipe");
    let mut command = folder.command(&small(&["--views", "1", "--baselines", "off"]));
    let mut child = command.stdout(std::process::Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    assert!(child.wait().unwrap().success());
    assert_eq!(folder.names("out"), RESULT_FILES);
}

/// The poses are so wrong that the table seems to be a part of the object, and the box grows by it.
#[test]
fn a_box_that_grows_too_far_ends_no_scan() {
    let folder = Folder::new("grown-too-far");
    let args = [
        "--table",
        "known",
        "--box",
        "grows",
        "--noise",
        "d435i",
        "--pose-error-mm",
        "10",
        "--pose-error-deg",
        "1",
    ];
    let scan = [
        &["scan", "builtin:mug", "--candidates", "200", "--views", "6", "--baselines", "off", "--json"],
        &args[..],
    ];
    let run = folder.run(&scan.concat());
    let result: Value = serde_json::from_str(&run.stdout).unwrap();
    assert!(run.code == Some(0) && result["views"].as_u64().unwrap() >= 2, "{result}");
    assert!(run.stderr.ends_with(" mm apart; --register on aligns frames to each other\n"), "{}", run.stderr);
}
