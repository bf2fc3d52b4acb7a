//! A scanned part compared with its CAD model.

use crate::common::{Folder, small};
use nextview_sim::builtin;

/// The mug in another place and in millimetres, as CAD programs write it.
fn cad() -> String {
    let mesh = builtin::by_name("mug").unwrap();
    let center = mesh.bounds().center();
    let vertices = mesh.vertices().iter().map(|v| {
        let v = 1e3 * (v - center);
        format!("v {} {} {}\n", -v.y + 30.0, v.x - 7.0, v.z + 50.0)
    });
    let faces = mesh.triangles().iter().map(|t| format!("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1));
    vertices.chain(faces).collect()
}

#[test]
fn a_part_that_is_its_model_has_no_defects_wherever_it_stood() {
    let folder = Folder::new("inspect");
    folder.run(&small(&["--views", "6", "--baselines", "off"]));
    folder.write("cad.obj", cad());
    let words = ["inspect", "out", "--reference", "cad.obj", "--unit", "mm", "--out", "found", "--json"];
    let run = folder.run(&words);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let record: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
    assert_eq!(record["defects"], serde_json::json!([]), "{record}");
    assert!(record["within_share"].as_f64().unwrap() > 0.8, "{record}");
    assert!(record["standard_error_median_mm"].as_f64().unwrap() < 0.1, "{record}");
    assert!(record["fitted_share"].as_f64().unwrap() > 0.95, "{record}");
    assert_eq!(folder.names("found"), ["deviation.ply", "inspection.json"]);
    // Inside out, as after a mirroring.
    let turned: Vec<String> = cad()
        .lines()
        .map(|line| match line.strip_prefix("f ") {
            Some(face) => format!("f {}", face.split(' ').rev().collect::<Vec<_>>().join(" ")),
            None => line.to_owned(),
        })
        .collect();
    folder.write("turned.obj", turned.join("\n"));
    let of_turned = ["inspect", "out", "--reference", "turned.obj", "--unit", "mm", "--out", "too", "--json"];
    let run = folder.run(&of_turned);
    assert!(run.stderr.contains("run clockwise seen from outside, and are reversed"), "{}", run.stderr);
    let record: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
    assert_eq!(record["defects"], serde_json::json!([]), "{record}");
    assert!(record["within_share"].as_f64().unwrap() > 0.8, "{record}");
    let again = folder.run(&words);
    assert!(again.code == Some(1) && again.stderr.contains("replace them (--force)"), "{}", again.stderr);
}

#[test]
fn what_cannot_be_inspected_is_named() {
    let folder = Folder::new("inspect-faults");
    folder.run(&small(&["--views", "3", "--baselines", "off"]));
    folder.write("cad.obj", cad());
    folder.write(
        "other.off",
        "OFF\n4 4 0\n0 0 0\n90 0 0\n0 60 0\n0 0 30\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n",
    );
    let refused = |args: &[&str], code: i32, parts: &[&str]| {
        let run = folder.run(&[&["inspect"], args, &["--out=x"]].concat());
        assert_eq!(run.code, Some(code), "{args:?}: {}", run.stderr);
        parts.iter().for_each(|part| assert!(run.stderr.contains(part), "{part:?} in {}", run.stderr));
        assert!(!folder.path("x").exists(), "{args:?} left something");
    };
    refused(&["no", "--reference", "cad.obj", "--unit=mm"], 1, &["no: holds no results of a scan"]);
    refused(&["out", "--reference", "no.stl"], 1, &["no.stl: cannot be read"]);
    refused(&["out", "--reference", "other.off", "--unit=mm"], 1, &["other.off does not fit", "--unit"]);
    refused(&["out", "--reference", "cad.obj", "--tolerance-mm", "0"], 2, &["0 is not positive"]);
}
