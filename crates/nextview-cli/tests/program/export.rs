//! Results of a scan in the formats of other tools.

use crate::common::Folder;
use crate::recording::{SCAN, write_colors, write_recording};
use nextview_sim::mesh::{Unit, load};

/// Every format, and one of its files.
const FORMATS: [(&str, &str); 8] = [
    ("bop", "train/000001/mask_visib/000001_000000.png"),
    ("colmap", "sparse/0/points3D.bin"),
    ("foundationpose", "cam_in_ob/000001.txt"),
    ("nerfstudio", "transforms.json"),
    ("obj", "mesh.png"),
    ("open3d", "trajectory.log"),
    ("pcd", "cloud.pcd"),
    ("tum", "groundtruth.txt"),
];

#[test]
fn a_scan_is_written_in_every_form() {
    let folder = Folder::new("export-formats");
    write_recording(&folder, 3);
    write_colors(&folder, 3);
    folder.run(&SCAN);
    for (format, file) in FORMATS {
        let printed = folder.ok(&["export", "out", "--to", format, "--out", format]);
        assert_eq!(printed, format!("3 views as {format} in {format}\n"));
        assert!(folder.path(&format!("{format}/{file}")).is_file(), "{format}");
        let again = folder.run(&["export", "out", "--to", format, "--out", format]);
        assert!(
            again.code == Some(1) && again.stderr.contains("(--out), or replace them (--force)"),
            "{again:?}"
        );
        folder.ok(&["export", "out", "--to", format, "--out", format, "--force"]);
    }
    // The exported sequence is a recording itself.
    folder.ok(&["scan", "--frames", "tum", "--voxel-size-m", "0.01", "--out=back"]);
}

#[test]
fn what_cannot_be_exported_is_named() {
    let folder = Folder::new("export-faults");
    write_recording(&folder, 2);
    write_colors(&folder, 1);
    folder.run(&SCAN);
    let refused = |args: &[&str], code: i32, parts: &[&str]| {
        let run = folder.run(&[&["export"], args].concat());
        assert_eq!(run.code, Some(code), "{args:?}: {}", run.stderr);
        parts.iter().for_each(|part| assert!(run.stderr.contains(part), "{part:?} in {}", run.stderr));
        assert!(!folder.path("x").exists(), "{args:?} left something");
    };
    refused(
        &["rec", "--to", "tum", "--out=x"],
        1,
        &["rec: holds no results of a scan", "name the folder with the results of a scan"],
    );
    refused(&["out", "--to", "tum", "--out=out"], 1, &["out: is the folder of the results", "(--out)"]);
    refused(&["out", "--to", "ply", "--out=x"], 2, &["[possible values: bop, colmap, foundationpose,"]);
    for format in ["colmap", "foundationpose", "nerfstudio", "obj"] {
        let message = format!("frame 2 has no colour image, which {format} requires");
        refused(&["out", "--to", format, "--out=x"], 1, &[&message]);
    }
    let note = folder.run(&["export", "out", "--to", "bop", "--out=bop"]).stderr;
    assert_eq!(note, "note: 1 of 2 frames have no colour image\n");
    folder.write("out/mesh.ply", "ply\nformat ternary 1.0\nend_header\n");
    refused(&["out", "--to", "bop", "--out=x"], 1, &["out/mesh.ply: line 2: ", "ternary"]);
    std::fs::rename(folder.path("out/frames"), folder.path("elsewhere")).unwrap();
    refused(&["out", "--to", "bop", "--out=x"], 1, &["out: holds no frames of the scan", "scan again"]);
    std::fs::remove_file(folder.path("out/record.json")).unwrap();
    refused(
        &["out", "--to", "bop", "--out=x"],
        1,
        &["out: holds no results of a scan: there is no record.json"],
    );
}

#[test]
fn frames_of_ones_own_are_not_replaced() {
    let folder = Folder::new("export-own-frames");
    folder.write("out/frames/notes.txt", "mine");
    let run = folder.run(&["scan", "builtin:mug", "--views=1", "--out=out", "--force"]);
    assert_eq!(run.code, Some(1));
    assert!(run.stderr.contains("out/frames: holds notes.txt, which a scan would remove"), "{}", run.stderr);
    assert_eq!(folder.bytes("out/frames/notes.txt"), b"mine");
}

/// A tetrahedron of 0.1 m as OBJ, with the other content of the file.
fn tetrahedron(head: &str, corners: [&str; 4]) -> String {
    let [a, b, c, d] = corners;
    let vertices = "v -0.05 -0.04 0\nv 0.05 -0.04 0\nv 0 0.05 0\nv 0 0 0.1\nvt 0.5 0.5\n";
    format!("{head}{vertices}f {a} {c} {b}\nf {a} {b} {d}\nf {b} {c} {d}\nf {c} {a} {d}\n")
}

#[test]
fn an_object_with_a_colour_becomes_a_mesh_with_that_colour() {
    let folder = Folder::new("export-colored");
    folder.write("plain.mtl", "newmtl plain\nKd 0.8 0.2 0.4\n");
    folder.write("plain.obj", tetrahedron("mtllib plain.mtl\nusemtl plain\n", ["1", "2", "3", "4"]));
    let scan =
        ["scan", "plain.obj", "--unit=m", "--views=4", "--baselines=off", "--noise=d435i", "--out=out"];
    folder.ok(&scan);
    assert!(folder.path("out/frames/color").is_dir());
    for (format, stem) in [("obj", "mesh"), ("foundationpose", "model/model")] {
        folder.ok(&["export", "out", "--to", format, "--out", format]);
        let stem = format!("{format}/{stem}");
        assert!(folder.text(&format!("{stem}.mtl")).contains("\nmap_Kd m"));
        let [obj, png] = ["obj", "png"].map(|end| folder.path(&format!("{stem}.{end}")));
        assert!(png.is_file());
        // Read back, every point has the colour, darker by the light from 1 down to 0.6.
        let (mesh, _) = load(&obj).unwrap().to_metres(Unit::Metres).unwrap();
        let mut n_right = 0;
        for triangle in 0..mesh.triangles().len() {
            let [red, green, blue] = mesh.color(triangle, [0.4, 0.3, 0.3]).unwrap();
            n_right += usize::from(
                (155..=205).contains(&red) && (38..=52).contains(&green) && (77..=103).contains(&blue),
            );
        }
        assert!(20 * n_right > 19 * mesh.triangles().len(), "{n_right} of {}", mesh.triangles().len());
    }
    // Equal bit for bit with another number of threads.
    folder.ok(&["export", "out", "--to", "obj", "--out", "one", "--threads", "1"]);
    for name in ["mesh.obj", "mesh.mtl", "mesh.png"] {
        assert_eq!(folder.bytes(&format!("one/{name}")), folder.bytes(&format!("obj/{name}")), "{name}");
    }
}

#[test]
fn a_mesh_whose_colours_are_broken_is_scanned_without_and_that_is_said() {
    let folder = Folder::new("export-broken-colors");
    folder.write("image.mtl", "newmtl image\nmap_Kd image.png\n");
    let corners = ["1/1", "2/1", "3/1", "4/1"];
    for (name, problem) in [("none", "line 1: \"none.mtl\": "), ("image", "line 2: texture \"image.png\": ")]
    {
        let object = format!("{name}.obj");
        folder.write(&object, tetrahedron(&format!("mtllib {name}.mtl\nusemtl image\n"), corners));
        let printed =
            folder.ok(&["scan", &object, "--unit=m", "--views=1", "--baselines=off", "--out", name]);
        let note = printed.lines().find(|line| line.starts_with("note: the mesh is used without colours: "));
        assert!(note.is_some_and(|note| note.contains(problem)), "{printed}");
        assert!(!folder.path(&format!("{name}/frames/color")).exists());
    }
}
