//! Every fault is reported immediately, on stderr, with place and remedy; nothing else happens.

use crate::common::{Folder, Run, small};
use crate::recording::{SCAN, png, write_recording};
use png::BitDepth;
use std::time::{Duration, Instant};

/// Faults must be found within this time: the work itself takes longer.
const AT_ONCE: Duration = Duration::from_secs(8);

const USAGE: i32 = 2;
const DATA: i32 = 1;

impl Folder {
    /// Runs the program, which must refuse with this exit code and a message that has all these parts.
    fn refused(&self, args: &[&str], code: i32, parts: &[&str]) {
        let before = self.names(".");
        let start = Instant::now();
        let run = self.run(args);
        assert!(start.elapsed() < AT_ONCE, "{args:?} took {:?}", start.elapsed());
        run.check_refusal(code, parts);
        assert_eq!(self.names("."), before, "{args:?} left something behind");
    }
}

impl Run {
    fn check_refusal(&self, code: i32, parts: &[&str]) {
        let Self { stdout, stderr, .. } = self;
        assert_eq!((self.code, stdout.as_str()), (Some(code), ""), "{stderr}");
        assert!(stderr.starts_with("error: ") && stderr.matches("error: ").count() >= 1, "{stderr}");
        assert!(!stderr.contains("panicked"), "{stderr}");
        // Keys of files have no backticks.
        let plain = stderr.replace('`', "");
        for part in parts {
            assert!(plain.contains(&part.replace('`', "")), "expected {part:?} in {stderr:?}");
        }
    }
}

fn ply(vertices: &[&str], faces: &[&str]) -> String {
    format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n{}\n{}\n",
        vertices.len(),
        faces.len(),
        vertices.join("\n"),
        faces.join("\n")
    )
}

/// Bytes without meaning, the same in every run.
fn garbage(n: usize) -> Vec<u8> {
    let mut state = 1_u32;
    let mut byte = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 24) as u8
    };
    (0..n).map(|_| byte()).collect()
}

#[test]
fn meshes_that_are_missing_empty_or_broken() {
    let folder = Folder::new("bad-mesh-files");
    let triangle = ply(&["0 0 0", "0.1 0 0", "0 0.1 0"], &["3 0 1 2"]);
    folder.refused(&["scan", "missing.ply"], DATA, &["missing.ply: cannot be read", "readable mesh file"]);
    folder.refused(&["scan", "."], DATA, &["mesh format", ".ply, .obj"]);
    folder.refused(&["scan", "teapot"], DATA, &["teapot: ", "hint: ", "builtin:teapot"]);
    folder.refused(&["scan", "random-17"], DATA, &["random-17: ", "hint: ", "builtin:random-17"]);
    for name in ["cup", "random-x", "random-9223372036854775808"] {
        let hint = "hint: the built-in objects are teapot, mug, bracket, torus-knot, and random-N with a whole number N from 0 to";
        folder.refused(&["scan", &format!("builtin:{name}")], USAGE, &[&format!("'{name}'"), hint]);
    }
    for extension in ["ply", "obj", "stl", "off", "gltf", "glb"] {
        let name = format!("empty.{extension}");
        folder.write(&name, "");
        folder.refused(&["scan", &name], DATA, &[&name]);
        let name = format!("garbage.{extension}");
        folder.write(&name, garbage(5000));
        folder.refused(&["scan", &name], DATA, &[&name]);
    }
    folder.write("cut.ply", &triangle[..triangle.len() - 8]);
    folder.refused(&["scan", "cut.ply"], DATA, &["cut.ply: end of the file", "1 face"]);
    let binary = triangle.replace("ascii", "binary_little_endian").replace("vertex 3", "vertex 1000");
    folder.write("cut-binary.ply", binary);
    folder.refused(&["scan", "cut-binary.ply"], DATA, &["cut-binary.ply: byte ", "1000 vertex", "truncated"]);
}

#[test]
fn meshes_without_a_surface() {
    let folder = Folder::new("bad-meshes");
    folder.write("points.ply", ply(&["0 0 0", "1 0 0"], &[]));
    folder.refused(&["scan", "points.ply"], DATA, &["points.ply: ", "no face", "at least one triangle"]);
    folder.write("nan.ply", ply(&["0 0 0", "nan 0 0", "0 1 0"], &["3 0 1 2"]));
    folder.refused(&["scan", "nan.ply"], DATA, &["nan.ply: vertex 1", "NaN"]);
    folder.write("index.ply", ply(&["0 0 0", "1 0 0", "0 1 0"], &["3 0 1 7"]));
    folder.refused(&["scan", "index.ply"], DATA, &["index.ply: line ", "vertex 7"]);
    folder.write("dot.ply", ply(&["1 1 1", "1 1 1", "1 1 1"], &["3 0 1 2"]));
    folder.refused(&["scan", "dot.ply"], DATA, &["dot.ply: ", "1 degenerate"]);
}

#[test]
fn objects_of_the_wrong_size() {
    let folder = Folder::new("bad-units");
    folder.write("mm.ply", ply(&["0 0 0", "150 0 0", "0 100 50"], &["3 0 1 2"]));
    folder.refused(&["scan", "mm.ply", "--unit", "m"], DATA, &["mm.ply: ", "150 m", "--unit"]);
    folder.write("m.ply", ply(&["0 0 0", "0.15 0 0", "0 0.1 0.05"], &["3 0 1 2"]));
    folder.refused(&["scan", "m.ply", "--unit", "mm"], DATA, &["m.ply: ", "0.00015 m", "--unit"]);
    folder.write("either.ply", ply(&["0 0 0", "10 0 0", "0 5 0"], &["3 0 1 2"]));
    folder.refused(&["scan", "either.ply"], DATA, &["either.ply: ", "state the --unit as m or mm"]);
    folder.refused(&["scan", "--pose-error-mm", "2000"], USAGE, &["--pose-error-mm is 2000", "0 to 1000"]);
    folder.refused(&["scan", "--pose-error-deg", "-1"], USAGE, &["--pose-error-deg", "-1 is negative"]);
    folder.refused(
        &["scan", "--min-overlap", "1.5"],
        USAGE,
        &["--min-overlap", "1.5 is not between 0 and 1"],
    );
    folder.refused(&["scan", "--register", "maybe"], USAGE, &["--register", "maybe"]);
    folder.refused(&["scan", "--size-m", "100"], USAGE, &["100 m", "10 m"]);
    folder.refused(&["scan", "--size-m", "6.434000015258789"], USAGE, &["side is 6.434 m,"]);
    folder.refused(&["scan", "--size-m", "1e-6"], USAGE, &["0.000001 m", "0.0001 m"]);
}

#[test]
fn options_out_of_range() {
    let folder = Folder::new("bad-options");
    let refused = |args: &[&str], parts: &[&str]| {
        folder.refused(&[&["scan", "builtin:mug"], args].concat(), USAGE, parts);
    };
    refused(&["--planner", "best"], &["'best'", "max-flow, local, apora, rse,", "random, clairvoyant"]);
    for theta in ["-0.1", "1.5", "nan", "some"] {
        refused(&["--theta", theta], &["--theta", theta]);
    }
    for size in ["0", "-0.01", "nan", "inf", "small"] {
        refused(&["--voxel-size-m", size], &["--voxel-size-m", size]);
    }
    refused(
        &["--voxel-size-m", "0.00001"],
        &["MB, more than the limit of 4096 MB", "hint: ", "--voxel-size-m"],
    );
    refused(&["--voxel-size-m", "0.0002"], &["MB, more than the limit of 4096 MB", "memory_limit_mb"]);
    refused(&["--voxel-size-m", "5"], &["voxel size is 5 m", "half", "in metres"]);
    refused(&["--first-view", "1000"], &["--first-view is 1000", "0 to 999"]);
    refused(&["--views", "0"], &["--views is 0", "1 to 1000"]);
    refused(&["--views", "30", "--candidates", "20"], &["--views is 30", "1 to 20"]);
    refused(&["--views", "-3"], &["--views", "'-3' is not a whole number"]);
    refused(&["--candidates", "0"], &["candidates is 0", "expected 1"]);
    refused(&["--seed", "-1"], &["--seed", "-1"]);
    refused(&["--size-m", "-1"], &["--size-m", "not positive"]);
    refused(&["--threads", "0"], &["--threads", "1..=1024"]);
    refused(&["--out", ""], &["--out"]);
    refused(&["--colour"], &["--colour", "--help"]);
}

#[test]
fn view_files_with_faults() {
    let folder = Folder::new("bad-views");
    folder.write("row.csv", "x_m,y_m,z_m\n0.4,0,0.1\n0.4,zero,0.1\n");
    folder.write("short.csv", "0.4,0,0.1\n0.4,0\n");
    folder.write("empty.csv", "");
    folder.write("garbage.csv", garbage(3000));
    folder.write("away.csv", "0.3,0,0.05\n9,9,9\n");
    for (file, parts) in [
        ("row.csv", ["line 3: column 2: 'zero' is not a number"].as_slice()),
        ("short.csv", &["line 2: 2 columns, expected at least 3"]),
        ("empty.csv", &["at least one view"]),
        ("garbage.csv", &["line 1"]),
        ("away.csv", &["view 1 ", "[9.000, 9.000, 9.000] m", "hint: views must be in metres"]),
        ("spehre", &["cannot be read", "hint: ", "shell, sphere, hemisphere, tammes, rings, ring"]),
    ] {
        let parts = [parts, &[file]].concat();
        folder.refused(&["scan", "builtin:mug", "--views", "1", "--view-space", file], DATA, &parts);
    }
    folder.write("few.csv", "0.3,0,0.05\n");
    folder.refused(
        &["scan", "--view-space", "few.csv", "--first-view", "1"],
        USAGE,
        &["--first-view is 1", "0 to 0"],
    );
    // Poses inside the room that all look away from the object.
    folder.write("blind.csv", "0.3,0,0.05,0,0,0,1\n");
    let blind = ["scan", "builtin:mug", "--view-space", "blind.csv", "--views", "1", "--json"];
    folder.refused(&blind, DATA, &["no view candidate sees the object"]);
}

#[test]
fn configurations_with_faults() {
    let folder = Folder::new("bad-configs");
    for (i, (text, parts)) in [
        ("views = \n", ["line 1, column 9"].as_slice()),
        ("voxels = 3\n", &["`voxels`", "`voxel_size_m`"]),
        ("[max_flow]\ngama = 1\n", &["`gama`", "`gamma`", "`max_flow`"]),
        ("[max_flow]\ngamma = 2\n", &["gamma is 2", "0..=1"]),
        ("[greedy]\ntheta = 2\n", &["theta is 2", "0..=1"]),
        ("[map.sensor_model]\nhit = 0.2\n", &["hit is 0.2", "0.5..1"]),
        ("[stop]\nentropy_share = 7\n", &["entropy_share is 7", "0..=1"]),
        ("[camera]\nfx = -1\n", &["camera.fx", "-1"]),
        ("[noise]\nmodel = \"kinect\"\n", &["`kinect`", "one of none, d435i, sensor"]),
        ("[noise]\npose_error_deg = 90\n", &["pose_error_deg is 90", "0 to 57"]),
        ("[noise.depth]\nmin_depth = 0.1\n", &["`min_depth`", "`min_depth_m`"]),
        ("[noise.depth]\nedge_loss = 2\n", &["edge_loss is 2", "0..=1"]),
        ("voxel_size_m = nan\n", &["voxel_size_m is NaN", "positive"]),
        ("size_m = 0\n", &["size_m is 0", "positive"]),
        ("views = -1\n", &["-1", "`views`"]),
        ("views = \"x\"\n", &["\"x\"", "`views`"]),
        ("profile = \"thesis\"\n", &["`thesis`", "`paper` or `default`"]),
    ]
    .into_iter()
    .enumerate()
    {
        let name = format!("{i}.toml");
        folder.write(&name, text);
        let parts = [parts, &[name.as_str()]].concat();
        folder.refused(&["scan", "--config", &name], DATA, &parts);
    }
    folder.write("garbage.toml", garbage(500));
    folder.refused(&["scan", "--config", "garbage.toml"], DATA, &["garbage.toml: cannot be read", "UTF-8"]);
    folder.refused(&["scan", "--config", "missing.toml"], DATA, &["missing.toml: cannot be read"]);
    folder.refused(&["scan", "--config", "."], DATA, &["cannot be read"]);
}

#[test]
fn specifications_with_faults() {
    let folder = Folder::new("bad-specs");
    let name = "name = \"x\"\n";
    for (i, (text, parts)) in [
        ("name = \n", ["line 1"].as_slice()),
        ("seeds = [0]\n", &["name: is missing"]),
        ("name = \"a/b\"\n", &["name is \"a/b\"", "folder"]),
        ("name = \"x\"\nvariants = 1\n", &["`variants`", "`variant`"]),
        ("seeds = []", &["seeds is empty"]),
        ("seeds = [1, 2, 1]", &["seeds has 1 twice"]),
        ("seeds = [-1]", &["line 2", "-1"]),
        ("first_views = [0, 0]", &["first_views has 0 twice"]),
        ("first_views = [2000]", &["first view 2000 is not among the 1000"]),
        ("scan.views = 2000", &["views is 2000, expected 1 to 1000"]),
        ("scan.candidates = 0", &["first view 0 is not among the 0"]),
        ("scan.voxels = 1", &["line 2, column 6", "`voxels`"]),
        ("scan.profile = \"thesis\"", &["`thesis`", "`paper` or `default`"]),
        ("scan.seed = 1", &["`seed`", "`seeds` sets it"]),
        ("[[variant]]\n[[variant]]\nscan.max_flow.gamma = 2", &["variant 2: max_flow.gamma is 2", "0..=1"]),
        ("[[variant]]\nlabel = \"a\"\nscan.planner = \"best\"", &["variant 1 (\"a\"): ", "`best`"]),
        (
            "[[variant]]\nscan.planner = \"python:planners:Best\"",
            &["variant 1: the planner python:planners:Best is written in Python", "nextview.bench"],
        ),
        ("[[variant]]\nsweep.gamma = 1", &["sweep.gamma is 1", "a list"]),
        ("[[variant]]\nsweep.views = []", &["sweep.views is empty"]),
        ("[[variant]]\nsweep.first_view = [1]", &["`first_view`", "`first_views`"]),
        ("[[variant]]\nsweep.\"greedy.gamma\" = [0, 1]", &["variant 1: ", "`gamma`", "`theta`"]),
        ("[[variant]]\nlabel = \"{gamma}\"", &["{gamma} is not a key"]),
        ("[[variant]]\nlabel = \"{views\"", &["without a '}'"]),
        (
            "[[variant]]\nscan.planner = \"local\"\nscan.stop.completeness = 0.9",
            &["variant 1", "planner local cannot stop"],
        ),
        ("[[variant]]\n[[variant]]", &["two variants are labelled \"most-surface\"", "hint: "]),
        ("objects = [1]", &["object 1 is of type integer", "a file or a table"]),
        ("objects = [\"a.ply\", { file = \"b.ply\", units = \"mm\" }]", &["object 2: ", "`units`", "`unit`"]),
        ("objects = [{ file = \"a.ply\", unit = \"cm\" }]", &["object 1: ", "`cm`", "`mm`"]),
        ("objects = [{ file = \"a.ply\", size_m = -1 }]", &["object 1", "size_m: is -1"]),
        ("objects = [\"a/x.ply\", \"b/x.ply\"]", &["two objects are named \"x\"", "b/x.ply", "hint: "]),
        ("objects = [\"none/*.ply\"]", &["none/*.ply: matches no file"]),
        ("objects = [{ file = \"*.toml\", name = \"x\" }]", &["files match", "name"]),
    ]
    .into_iter()
    .enumerate()
    {
        let file = format!("{i}.toml");
        let head = if text.contains("name = ") && !text.starts_with("objects") || i == 1 { "" } else { name };
        folder.write(&file, format!("{head}{text}\n"));
        let parts = [parts, &[file.as_str()]].concat();
        folder.refused(&["bench", &file], DATA, &parts);
    }
    folder.refused(&["bench", "paper"], DATA, &["paper: cannot be read", "hint: ", "paper-1, paper-2"]);
    folder.refused(&["bench"], USAGE, &["no specification", "hint: ", "--list"]);
    folder.refused(&["bench", "--resume", "--out", "none"], DATA, &["none/spec.toml: cannot be read"]);
    folder.refused(&["bench", "paper-1", "--jobs", "0"], USAGE, &["--jobs", "1..=1024"]);
}

#[test]
fn recordings_with_faults() {
    let folder = Folder::new("bad-recordings");
    write_recording(&folder, 3);
    let with = |name: &str, content: Vec<u8>, parts: &[&str]| {
        let before = folder.bytes(name);
        folder.write(name, content);
        folder.refused(&SCAN, DATA, &[parts, &[&*format!("{name}: ")]].concat());
        folder.write(name, before);
    };
    let text = |name: &str, from: &str, to: &str, parts: &[&str]| {
        with(name, folder.text(name).replacen(from, to, 1).into(), parts);
    };
    let image = |bits, byte| png(160, 120, bits, &vec![byte; 160 * 120 * bits as usize / 8]);
    with("rec/depth/001.png", image(BitDepth::Eight, 9), &["8 bits without colour", "16 bits"]);
    with(
        "rec/depth/001.png",
        folder.bytes("rec/depth/001.png")[..999].to_vec(),
        &["not a complete PNG image"],
    );
    text("rec/intrinsics.txt", "cx 79.5", "cx 790", &["principal point", "790"]);
    text("rec/poses.csv", "\n1,", "\n0,", &["line 3: frame 0 is already in line 2"]);
    let poses = folder.bytes("rec/poses.csv");
    with("rec/poses.csv", poses[..poses.len() - 50].to_vec(), &["line 4: ", "columns, expected 13"]);
    let poses = folder.text("rec/poses.csv");
    let twice = poses.lines().map(|line| {
        let (frame, pose) = line.split_once(',').unwrap();
        format!(
            "{frame},{},{}\n",
            pose.replace("world_from_camera", "given"),
            pose.replace("world_from", "other")
        )
    });
    let parts = ["several sets of pose columns, given, other_camera: choose one as --pose-columns"];
    with("rec/poses.csv", twice.collect::<String>().into(), &parts);
    folder.refused(&["scan", "--frames", "missing"], DATA, &["missing: cannot be read"]);
    folder.refused(&["scan", "--frames", "."], DATA, &["is not a recording", "poses.csv"]);
}

#[test]
fn questions_that_recordings_cannot_answer() {
    let folder = Folder::new("bad-recorded-options");
    write_recording(&folder, 3);
    let refused = |args: &[&str], parts: &[&str]| {
        folder.refused(&[&SCAN, args].concat(), USAGE, parts);
    };
    for option in
        ["builtin:mug", "--candidates=9", "--view-space=sphere", "--box=grows", "--noise=d435i", "--size-m=1"]
    {
        refused(&[option], &["--frames <PATH>", "cannot be used with"]);
    }
    refused(&["--table", "known"], &["--table is for simulations", "hint: --table-z-m states its height"]);
    refused(&["--table", "fit", "--table-z-m", "0"], &["--table-z-m states the table", "hint: leave out "]);
    refused(&["--views", "4"], &["--views is 4, expected 1 to 3"]);
    refused(&["--views", "10"], &["--views is 10, expected 1 to 3"]);
    refused(&["--views", "2", "--first-view", "3"], &["--first-view is 3, expected 0 to 2"]);
    refused(&["--views", "2", "--planner", "clairvoyant"], &["true object", "--truth"]);
    refused(
        &["--views", "2", "--box-m", "0,0,0,1,1,0"],
        &["--box-m is [0, 0, 0] to [1, 1, 0]", "lowest first"],
    );
    refused(&["--views", "2", "--box-m", "0,0,0,1,1"], &["--box-m", "5 numbers, expected 6"]);
    refused(&["--views", "2", "--truth-from-world", "t.txt"], &["--truth-from-world needs --truth"]);
    for option in ["--pose-columns=x", "--box-m=0,0,0,1,1,1", "--truth=a.ply", "--truth-from-world=t.txt"] {
        folder.refused(&["scan", option], USAGE, &["needs --frames"]);
    }
    let bad_data = |args: &[&str], parts: &[&str]| {
        folder.refused(&[&SCAN[..], &["--views=2", "--json"], args].concat(), DATA, parts);
    };
    folder.write("t.txt", "1 0 0 0\n0 1 0 0\n0 0 2 0\n0 0 0 1\n");
    bad_data(
        &["--truth", "mug.obj", "--unit", "m", "--truth-from-world", "t.txt"],
        &["t.txt: the rotation is not rigid"],
    );
    bad_data(&["--truth", "missing.obj"], &["missing.obj: cannot be read"]);
    folder.write("far.obj", "v 9 9 9\nv 9.1 9 9\nv 9 9.1 9\nf 1 2 3\n");
    bad_data(&["--truth", "far.obj", "--unit", "m"], &["so they do not match", "hint: --truth-from-world"]);
    folder.write("c.toml", "object = \"rec\"\ncandidates = 7\n[recording]\n");
    folder.refused(&["scan", "--config", "c.toml"], DATA, &["c.toml", "candidates is for simulations"]);
    folder.write("c.toml", "name = \"x\"\n[scan.recording]\n");
    folder.refused(&["bench", "c.toml"], DATA, &["recording is for single scans"]);
}

#[test]
fn maps_that_are_cut_or_lie() {
    let folder = Folder::new("bad-maps");
    folder.ok(&small(&["--views", "1", "--baselines", "off"]));
    let half = |name: &str| folder.bytes(name).split_at(folder.bytes(name).len() / 2).0.to_vec();
    folder.write("cut.ot", half("out/map.ot"));
    folder.write("cut.bt", half("out/map.bt"));
    let header = "# Octomap OcTree file\nid OcTree\nsize 1152921504606846976\nres 0.01\ndata\n";
    folder.write("huge.ot", [header.as_bytes(), &[0, 0, 0, 0, 1]].concat());
    folder.write("empty.ot", "");
    folder.write("garbage.ot", garbage(5000));
    folder.write("views.csv", "0.4,0,0.1\n");
    for (file, part) in [
        ("cut.ot", "the data ends after"),
        ("cut.bt", "the data ends after"),
        ("huge.ot", "1 of 1152921504606846976 nodes"),
        ("empty.ot", "line 1"),
        ("garbage.ot", "line 1"),
        ("missing.ot", "cannot be read"),
        ("out", "is a folder"),
    ] {
        let parts = [file, part];
        folder.refused(&["map", "info", file], DATA, &parts);
        folder.refused(&["map", "convert", file, "new.bt"], DATA, &parts);
        folder.refused(&["plan", "--map", file, "--views", "views.csv"], DATA, &parts);
    }
}

#[test]
fn questions_that_a_map_cannot_answer() {
    let folder = Folder::new("bad-questions");
    folder.ok(&small(&["--views", "1", "--baselines", "off"]));
    folder.write("views.csv", "0.4,0,0.1\n");
    let map = "out/map.ot";
    for to in ["new.txt", "new", "views.csv"] {
        folder.refused(&["map", "convert", map, to], USAGE, &[to, ".ot, .bt or .ply"]);
    }
    for (cube, part) in [
        ("1,2,3", "cx,cy,cz,half"),
        ("1,2,3,-1", "positive"),
        ("0,0,0,1e30", "--box"),
        ("9,9,9,0.0001", "--box"),
    ] {
        folder.refused(&["map", "info", map, "--box", cube], USAGE, &[part]);
    }
    let plan = |args: &[&str], code: i32, parts: &[&str]| {
        folder.refused(&[&["plan", "--map", map, "--views", "views.csv"], args].concat(), code, parts);
    };
    plan(&["--visited", "1"], USAGE, &["--visited is 1", "0 to 0"]);
    plan(&["--visited", "-1"], USAGE, &["--visited"]);
    for planner in ["clairvoyant", "proximity-count", "see"] {
        let parts = [&format!("invalid value '{planner}'"), "possible values: most-surface, max-flow, local"];
        plan(&["--planner", planner], USAGE, &parts);
    }
    plan(&["--theta", "1.5"], USAGE, &["--theta", "1.5 is not between 0 and 1"]);
    plan(&["--box", "0,0,0,100"], USAGE, &["MB, more than the limit", "--box"]);
    plan(&["--box", "0,0,0,1e30"], USAGE, &["--box"]);
    folder.refused(&["plan", "--map", map, "--views", "missing.csv"], DATA, &["missing.csv: cannot be read"]);
    folder.write("mm.csv", "400,0,100\n0,400,100\n");
    let parts = ["mm.csv: no view is within 10 m", "nearest, view 0", "may be in millimetres"];
    folder.refused(&["plan", "--map", map, "--views", "mm.csv"], DATA, &parts);
    folder.refused(&["views", "--count", "0"], USAGE, &["candidates is 0"]);
    for size in ["1e308", "1e-320"] {
        folder.refused(
            &["views", "--size-m", size],
            USAGE,
            &["--size-m is ", "expected 0.000001 to 1000000 m"],
        );
    }
    folder.refused(
        &["views", "--center", "0,0,1e300"],
        USAGE,
        &["--center is [0, 0, 1000000", "expected coord"],
    );
    folder.refused(&["views", "--center", "1,2"], USAGE, &["--center", "x,y,z"]);
}

/// Tests may run as root, which may write everywhere, so a file is in the way.
#[cfg(unix)]
#[test]
fn places_that_cannot_be_written() {
    let folder = Folder::new("bad-places");
    folder.write("file", "mine");
    folder.refused(
        &["scan", "--out", "file"],
        DATA,
        &["file: exists and is not a folder", "hint: ", "--out"],
    );
    folder.refused(&["scan", "--out", "file/below"], DATA, &["file/below: cannot be written", "hint: "]);
    folder.refused(&["scan", "--out", "/dev/null/below"], DATA, &["/dev/null/below: cannot be written"]);
    folder.refused(
        &["views", "--out", "none/views.csv"],
        DATA,
        &["none/views.csv: cannot be written", "hint: "],
    );
    folder.refused(&["views", "--out", "."], DATA, &[".: cannot be written"]);
    assert_eq!(folder.text("file"), "mine");
}

#[cfg(target_os = "linux")]
#[test]
fn the_system_may_forbid_a_folder() {
    let folder = Folder::new("bad-system");
    folder.refused(&["scan", "--out", "/proc/new"], DATA, &["/proc/new: cannot be written", "hint: "]);
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_behind_a_file_or_stdout() {
    let folder = Folder::new("full-device");
    folder.refused(
        &["views", "--out", "/dev/full"],
        DATA,
        &["/dev/full: cannot be written: No space", "hint: "],
    );
    let full = || std::fs::File::options().write(true).open("/dev/full").unwrap();
    for args in [&["views", "--count", "3"], &["scan", "builtin:mug", "--views=1"]] {
        let mut command = folder.command(args);
        command.stdout(full());
        Run::of(command).check_refusal(DATA, &["stdout: cannot be written: No space"]);
    }
    assert_eq!(folder.names("."), [""; 0]);
}

/// Requires permission to mount a small disk, at least in a separate name space.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_leaves_nothing_behind() {
    let folder = Folder::new("full-disk");
    std::fs::create_dir(folder.path("disk")).unwrap();
    let in_namespace = |script: &str| {
        let mut command = std::process::Command::new("unshare");
        let mount = "mount -t tmpfs -o size=64k tmpfs disk";
        command.args(["-rm", "sh", "-c", &format!("{mount} && {script}")]).current_dir(folder.path("."));
        command.output()
    };
    if !in_namespace("true").is_ok_and(|output| output.status.success()) {
        let test = "a_full_disk_leaves_nothing_behind";
        return nextview_checks::skipped(test, "tmpfs", "a tmpfs cannot be mounted");
    }
    let scan = small(&["--views", "1", "--baselines", "off", "--json", "--out"]);
    let man = ["man", "--out"];
    let outs = ["disk", "disk/new/results"];
    for (command, out) in outs.into_iter().flat_map(|out| [(&scan[..], out), (&man[..], out)]) {
        let args = [command, &[out]].concat();
        let program = env!("CARGO_BIN_EXE_nextview");
        let script = format!("{program} {}; echo code $?; ls -A disk", args.join(" "));
        let output = in_namespace(&script.replace("--out=out ", "")).unwrap();
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert_eq!(String::from_utf8(output.stdout).unwrap(), "code 1\n", "{stderr}");
        assert!(stderr.contains(&format!("{out}/")) && stderr.contains("No space left"), "{stderr}");
    }
}
