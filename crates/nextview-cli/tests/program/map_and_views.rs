use crate::common::{Folder, data, small};
use nextview_sim::mesh;
use serde_json::Value;

/// Occupied voxels and entropy (nats) in the box of each of the authors' maps, from the README of the data.
const AUTHORS: [(u64, f64); 10] = [
    (253, 4972.79),
    (389, 4920.26),
    (458, 4857.12),
    (456, 4774.21),
    (481, 4704.43),
    (492, 4620.32),
    (504, 4554.41),
    (507, 4469.47),
    (507, 4387.50),
    (507, 4346.05),
];

/// The authors' box in the form of `--box`: the second and third line of their candidates.
fn authors_box(candidates: &str) -> String {
    let numbers: Vec<&str> = candidates.split_whitespace().skip(1).take(4).collect();
    numbers.join(",")
}

#[test]
fn authors_maps_have_the_known_counts_and_entropies() {
    let Some(authors) = data("authors_maps_have_the_known_counts_and_entropies", "authors") else { return };
    let folder = Folder::new("authors-info");
    let cube = authors_box(&std::fs::read_to_string(authors.join("candidate_views.txt")).unwrap());
    for (i, (n_occupied, entropy)) in AUTHORS.into_iter().enumerate() {
        let map = authors.join(format!("octomap{i}.ot"));
        let info = folder.json(&["map", "info", map.to_str().unwrap(), "--box", &cube, "--json"]);
        assert_eq!(info["occupied_voxels"], n_occupied, "map {i}");
        assert!((info["entropy_nats"].as_f64().unwrap() - entropy).abs() <= 0.01, "map {i}: {info}");
        let count = |key: &str| info[key].as_u64().unwrap();
        assert_eq!(count("occupied_voxels") + count("free_voxels") + count("unknown_voxels"), 7220);
    }
    let map = authors.join("octomap0.ot");
    let text = folder.ok(&["map", "info", map.to_str().unwrap(), "--box", &cube]);
    assert!(text.starts_with("kind             ColorOcTree\n"), "{text}");
    assert!(text.contains("\noccupied voxels  253  (P > 0.65)\n"), "{text}");
    assert!(text.ends_with("\nentropy          4972.79 nats\n"), "{text}");
}

#[test]
fn authors_maps_convert_to_the_same_bytes() {
    let Some(authors) = data("authors_maps_convert_to_the_same_bytes", "authors") else { return };
    let folder = Folder::new("authors-convert");
    let map = authors.join("octomap9.ot");
    folder.ok(&["map", "convert", map.to_str().unwrap(), "copy.ot"]);
    assert!(folder.bytes("copy.ot") == std::fs::read(&map).unwrap(), "colours and log-odds are kept");
}

#[test]
fn conversions_keep_what_the_format_can_hold() {
    let folder = Folder::new("convert");
    folder.ok(&small(&["--views", "2", "--baselines", "off"]));
    let info = |map: &str| folder.json(&["map", "info", map, "--json"]);

    folder.ok(&["map", "convert", "out/map.ot", "a.ot"]);
    assert_eq!(folder.bytes("a.ot"), folder.bytes("out/map.ot"));
    folder.ok(&["map", "convert", "a.ot", "b.bt"]);
    assert_eq!(folder.bytes("b.bt"), folder.bytes("out/map.bt"));
    folder.ok(&["map", "convert", "b.bt", "c.bt"]);
    assert_eq!(folder.bytes("c.bt"), folder.bytes("b.bt"));
    folder.ok(&["map", "convert", "b.bt", "d.ot"]);
    let [bt, ot] = ["b.bt", "d.ot"].map(info);
    assert_eq!(bt, ot);
    // In a .bt file, a voxel is occupied if P is at least 0.5.
    let occupied = bt["occupied_voxels"].as_u64().unwrap();
    assert!(occupied >= info("out/map.ot")["occupied_voxels"].as_u64().unwrap());

    // The output for people.
    folder.ok(&["map", "convert", "b.bt", "centers.ply"]);
    let ply = folder.bytes("centers.ply");
    let header = String::from_utf8_lossy(&ply[..100]).into_owned();
    assert!(header.contains(&format!("element vertex {occupied}\n")), "{header}");
    assert_eq!(folder.names("."), ["a.ot", "b.bt", "c.bt", "centers.ply", "d.ot", "out/"]);
}

#[test]
fn info_in_a_box_counts_all_its_voxels() {
    let folder = Folder::new("info-box");
    folder.ok(&small(&["--views", "1", "--baselines", "off"]));
    let info = folder.json(&["map", "info", "out/map.ot", "--box", "-0.05,0,0.05,0.05", "--json"]);
    let states = ["occupied_voxels", "free_voxels", "unknown_voxels"].map(|key| info[key].as_u64().unwrap());
    assert_eq!(states.iter().sum::<u64>(), 1000);
    assert!(states.iter().all(|n| *n > 0), "{info}");
    let nowhere = folder.json(&["map", "info", "out/map.ot", "--box", "5,5,5,0.05", "--json"]);
    assert_eq!((&nowhere["measured_voxels"], &nowhere["bounds_m"]), (&0.into(), &Value::Null));
    assert!((nowhere["entropy_nats"].as_f64().unwrap() - 1000.0 * 2.0_f64.ln()).abs() < 1e-9);
}

#[test]
fn every_rule_makes_views_that_plan_reads() {
    let folder = Folder::new("views");
    folder.ok(&small(&["--views", "1", "--baselines", "off"]));
    for rule in ["shell", "sphere", "hemisphere", "ring"] {
        let args = ["views", "--rule", rule, "--count", "12", "--center=-0.01,0,0.05", "--size-m", "0.08"];
        let csv = folder.ok(&args);
        folder.ok(&[args.as_slice(), &["--out", "views.csv", "--force"]].concat());
        assert_eq!(csv, folder.text("views.csv"));
        let rows: Vec<Vec<f64>> = csv
            .lines()
            .skip(1)
            .map(|row| row.split(',').map(|field| field.parse().unwrap()).collect())
            .collect();
        assert!(csv.starts_with("x_m,y_m,z_m,qx,qy,qz,qw\n") && rows.len() == 12);

        let plan = folder.json(&["plan", "--map", "out/map.ot", "--views", "views.csv", "--json"]);
        let view = plan["view"].as_u64().unwrap() as usize;
        let pose =
            ["position_m", "quaternion_xyzw"].map(|key| plan[key].as_array().unwrap().as_slice()).concat();
        let differences = pose.iter().zip(&rows[view]).map(|(a, b)| (a.as_f64().unwrap() - b).abs());
        assert!(pose.len() == 7 && differences.fold(0.0, f64::max) < 1e-12, "{rule}: {plan}");
    }
}

#[test]
fn plan_agrees_with_the_scan_that_made_the_map() {
    let folder = Folder::new("plan");
    let args = ["--view-space", "sphere", "--planner", "local", "--baselines", "off", "--json"];
    let scan = folder.json(&small(&[args.as_slice(), &["--views", "3"]].concat()));
    let chosen: Vec<u64> =
        scan["steps"].as_array().unwrap().iter().map(|step| step["view"].as_u64().unwrap()).collect();
    folder.json(&small(&[args.as_slice(), &["--views", "2"]].concat()));
    // The candidates and the box of the scan: around the mug, which stands on z = 0.
    let bounds = nextview_sim::builtin::by_name("mug").unwrap().bounds();
    let (center, size) = (bounds.center(), 0.5 * bounds.longest_side());
    let center = format!("{},{},{}", center.x, center.y, center.z);
    let cube = format!("{center},{}", 1.1 * size + 0.02);
    let size = size.to_string();
    folder.ok(&[
        "views",
        "--rule",
        "sphere",
        "--count",
        "20",
        "--center",
        &center,
        "--size-m",
        &size,
        "--out=v.csv",
    ]);
    let visited = format!("{},{}", chosen[0], chosen[1]);
    let args = ["plan", "--map", "out/map.ot", "--views", "v.csv", "--visited", &visited];
    let plan = folder.json(&[args.as_slice(), &["--box", &cube, "--planner", "local", "--json"]].concat());
    assert_eq!(plan["view"], chosen[2], "visited {visited}: {plan}");
    let text = folder.ok(&args);
    assert!(text.starts_with("next view   ") && text.contains("\nquaternion  "), "{text}");
}

#[test]
fn plan_pays_for_moving() {
    let folder = Folder::new("plan-theta");
    folder.ok(&small(&["--views", "1", "--baselines", "off"]));
    let args = ["--rule", "sphere", "--count", "30", "--center", "0,0,0.05", "--size-m", "0.08"];
    folder.ok(&[["views", "--out", "v.csv"].as_slice(), &args].concat());
    let first: Vec<f64> =
        folder.text("v.csv").lines().nth(1).unwrap().split(',').take(3).map(|x| x.parse().unwrap()).collect();
    let way = |theta: &str| {
        let args = ["--views", "v.csv", "--visited", "0", "--theta", theta, "--json"];
        let plan = folder.json(&[["plan", "--map", "out/map.ot"].as_slice(), &args].concat());
        let position = plan["position_m"].as_array().unwrap().clone();
        position.iter().zip(&first).map(|(x, from)| (x.as_f64().unwrap() - from).powi(2)).sum::<f64>().sqrt()
    };
    assert!(way("1") < 0.7 * way("0"), "{} m, and {} m where moving is free", way("1"), way("0"));
}

#[test]
fn plan_gives_a_batch_and_its_tour() {
    let folder = Folder::new("plan-batch");
    folder.ok(&small(&["--views", "1", "--baselines", "off"]));
    let args = ["--rule", "sphere", "--count", "30", "--center", "0,0,0.05", "--size-m", "0.08"];
    folder.ok(&[["views", "--out", "v.csv"].as_slice(), &args].concat());
    let args = ["plan", "--map", "out/map.ot", "--views", "v.csv", "--visited", "0", "--batch", "4"];
    let batch = |more: &[&str]| folder.json(&[args.as_slice(), &["--json"], more].concat());
    let free = batch(&[]);
    let number = |batch: &Value, key: &str| batch[key].as_f64().unwrap();
    let views = free["views"].as_array().unwrap();
    assert!(views.len() == 4 && views.iter().all(|view| view["position_m"].as_array().unwrap().len() == 3));
    let shares = views.iter().map(|view| number(view, "share")).sum::<f64>();
    assert!((shares - number(&free, "share")).abs() < 1e-6 && shares <= 1.0 + 1e-9, "{free}");
    let of_best = number(&free, "share") / number(&free, "share_bound");
    assert!((of_best - number(&free, "share_of_best")).abs() < 1e-12 && of_best > 0.9, "{free}");
    let near = batch(&["--theta", "0.4"]);
    assert!(number(&near, "path_length_m") < number(&free, "path_length_m"), "{near} {free}");

    let text = folder.ok(&args);
    let lines: Vec<&str> = text.lines().collect();
    assert!(
        lines[0].starts_with("next views  4, which show ") && lines[1].starts_with("bound       "),
        "{text}"
    );
    let length = format!("path        {:.3} m", number(&free, "path_length_m"));
    assert_eq!((lines.len(), lines[2]), (9, length.as_str()));
    let listed =
        lines[5..].iter().map(|line| line.split_whitespace().next().unwrap().parse::<u64>().unwrap());
    assert!(listed.eq(views.iter().map(|view| view["view"].as_u64().unwrap())), "{text}");
}

#[test]
fn plan_says_when_nothing_is_left() {
    let folder = Folder::new("plan-none");
    folder.ok(&small(&["--views", "1", "--baselines", "off"]));
    let args = ["plan", "--map", "out/map.ot", "--views", "out/views.csv", "--visited", "0"];
    assert_eq!(folder.ok(&args), "next view   none: no candidate gains anything\n");
    let plan = folder.json(&[args.as_slice(), &["--json"]].concat());
    assert!(plan["view"].is_null() && plan["position_m"].is_null());
    let args = [args.as_slice(), &["--batch", "3"]].concat();
    assert_eq!(folder.ok(&args), "next views  none: no candidate gains anything\n");
    let batch = folder.json(&[args.as_slice(), &["--json"]].concat());
    assert!(batch["views"].as_array().unwrap().is_empty() && batch["path_length_m"] == 0.0, "{batch}");
}

#[test]
fn a_real_mesh_scans_and_its_surface_is_like_it() {
    let Some(bunny) = data("a_real_mesh_scans_and_its_surface_is_like_it", "meshes/stanford/bunny.ply")
    else {
        return;
    };
    let folder = Folder::new("bunny");
    let args =
        ["--size-m", "0.15", "--candidates", "30", "--views", "4", "--baselines", "off", "--out", "out"];
    let args =
        [&["scan", bunny.to_str().unwrap(), "--voxel-size-m", "0.01", "--json"], args.as_slice()].concat();
    let result = folder.json(&args);
    assert_eq!(result["object"], "bunny");
    let scanned = mesh::load(&folder.path("out/mesh.ply")).unwrap();
    assert!((scanned.longest_side() - 0.15).abs() < 0.01, "{}", scanned.longest_side());
}
