//! Valid and invalid files through the public entry point, and corrupted bytes into every parser.

use super::raw::RawMesh;
use super::*;
use crate::SimError;
use proptest::prelude::*;
use std::path::PathBuf;

/// A temporary folder, removed at the end.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("nextview-mesh-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn write(&self, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.join(name);
        std::fs::write(&path, content).unwrap();
        path
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        std::fs::remove_dir_all(&self.0).ok();
    }
}

const OBJ: &str = "v 0 0 0\nv 0.1 0 0\nv 0 0.2 0\nv 0 0 0.1\nf 1 2 3\nf 1 2 4\nf 1 1 2\n";
const OFF: &str = "OFF\n4 2 0\n0 0 0\n0.1 0 0\n0 0.2 0\n0 0 0.1\n3 0 1 2\n3 0 1 3\n";
const PLY_HEADER: &str = "element vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 2\n\
    property list uchar int vertex_indices\nend_header\n";
const STL: &str = "solid s\nfacet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n\
    endfacet\nendsolid\n";
const GLTF: &str = r#"{"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":
    {"POSITION":0}}]}],"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],
    "bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36,"uri":"my%20data.bin"}]}"#;

fn floats(numbers: &[f32]) -> Vec<u8> {
    numbers.iter().flat_map(|x| x.to_le_bytes()).collect()
}

fn ply_binary(order: &str) -> Vec<u8> {
    let mut bytes = format!("ply\nformat {order} 1.0\n{PLY_HEADER}").into_bytes();
    let is_big = order.contains("big");
    for coordinate in [0.0_f32, 0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 0.2, 0.0, 0.0, 0.0, 0.1] {
        bytes.extend(if is_big { coordinate.to_be_bytes() } else { coordinate.to_le_bytes() });
    }
    for corners in [[0_i32, 1, 2], [0, 1, 3]] {
        bytes.push(3);
        bytes.extend(corners.iter().flat_map(|c| if is_big { c.to_be_bytes() } else { c.to_le_bytes() }));
    }
    bytes
}

fn stl_binary() -> Vec<u8> {
    let mut bytes = vec![b'x'; 80];
    bytes.extend(1_u32.to_le_bytes());
    bytes.extend(floats(&[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]));
    bytes.extend([0, 0]);
    bytes
}

fn glb() -> Vec<u8> {
    let json = GLTF.replace(r#","uri":"my%20data.bin""#, "");
    let mut bytes = b"glTF\x02\0\0\0\0\0\0\0".to_vec();
    bytes.extend((json.len() as u32).to_le_bytes());
    bytes.extend(b"JSON");
    bytes.extend(json.as_bytes());
    bytes.extend(36_u32.to_le_bytes());
    bytes.extend(b"BIN\0");
    bytes.extend(floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]));
    bytes
}

/// A parser, and a valid file for it.
type Format = (&'static str, fn(&[u8]) -> Result<RawMesh, SimError>, Vec<u8>);

const COLORED_PLY: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
    property float z\nproperty uchar red\nproperty float green\nproperty uchar blue\nelement face 1\n\
    property list uchar int vertex_indices\nend_header\n0 0 0 255 0.5 0\n1 0 0 1 1 1\n0 1 0 0 0 0\n3 0 1 2\n";

fn colored_obj(bytes: &[u8]) -> Result<RawMesh, SimError> {
    obj::parse(bytes, &|_| Ok(b"newmtl a\nKd 1 0.5 0\n".to_vec()))
}

fn formats() -> [Format; 12] {
    let vertices_and_faces = OFF.split_once("0\n").unwrap().1;
    let gltf: fn(&[u8]) -> _ = |bytes| gltf::parse(bytes, &|_| Ok(vec![0; 36]));
    [
        ("obj", |bytes| obj::parse(bytes, &|_| Err(SimError::NotAFile)), OBJ.into()),
        ("off", off::parse, OFF.into()),
        ("ply", ply::parse, format!("ply\nformat ascii 1.0\n{PLY_HEADER}{vertices_and_faces}").into()),
        ("ply", ply::parse, ply_binary("binary_little_endian")),
        ("ply", ply::parse, ply_binary("binary_big_endian")),
        ("stl", stl::parse, STL.into()),
        ("stl", stl::parse, stl_binary()),
        ("gltf", gltf, GLTF.into()),
        ("glb", gltf, glb()),
        ("gltf", gltf, GLTF.replace("my%20data.bin", "data:;base64,AAAAAA==").into()),
        ("obj", colored_obj, format!("mtllib a.mtl\nusemtl a\nv 9 9 9 1 0.5 0\nvt 0 1\n{OBJ}").into()),
        ("ply", ply::parse, COLORED_PLY.into()),
    ]
}

#[test]
fn loads_every_format_by_its_extension() {
    let folder = Folder::new("formats");
    folder.write("my data.bin", floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]));
    for (i, (extension, _, bytes)) in formats().into_iter().enumerate().take(9) {
        let file = load(&folder.write(&format!("mesh{i}.{}", extension.to_uppercase()), bytes)).unwrap();
        let (mesh, scaling) = file.to_metres(Unit::Auto).unwrap();
        assert_eq!(scaling.metres_per_unit, 1.0);
        assert_eq!(file.n_dropped(), (extension == "obj") as usize);
        assert!(mesh.triangles().len() == 2 || file.longest_side() == 1.0);
    }
}

#[test]
fn tells_files_that_cannot_be_loaded_apart() {
    let folder = Folder::new("bad");
    let message = |path: PathBuf| {
        let message = load(&path).unwrap_err().to_string();
        assert!(message.starts_with(&path.display().to_string()), "{message} does not name the file");
        message
    };
    let check = |path: PathBuf, expected: &str| {
        let message = message(path);
        assert!(message.contains(expected), "{message:?} does not contain {expected:?}");
    };
    check(folder.0.join("missing.ply"), "cannot be read");
    std::fs::create_dir(folder.0.join("folder.ply")).unwrap();
    check(folder.0.join("folder.ply"), "not a regular file");
    check(folder.write("mesh.xyz", ""), "unknown mesh format \"xyz\", expected .ply, .obj");
    check(folder.write("mesh", ""), "its name has no extension, expected .ply, .obj");
    for extension in ["ply", "obj", "stl", "off", "gltf", "glb"] {
        message(folder.write(&format!("empty.{extension}"), ""));
        message(folder.write(&format!("noise.{extension}"), [0x9C_u8; 300]));
    }
    check(folder.write("cloud.obj", "v 0 0 0\n"), "no face with an area (0 degenerate");
    check(folder.write("flat.obj", "v 0 0 0\nv 1 0 0\nf 1 2 2\nf 1 2\n"), "(2 degenerate faces)");
    check(folder.write("nan.obj", OBJ.replace("0.2", "nan")), "vertex 2 (counted from 0) is [0, NaN, 0]");
    check(folder.write("far.obj", OBJ.replace("0.2", "1e31")), "vertex 2");
    check(folder.write("outside.gltf", GLTF.replace("my%20", "..%2Fmy")), "leads outside the mesh's folder");
    check(folder.write("absolute.gltf", GLTF.replace("my%20data.bin", "/etc/hosts")), "leads outside");
    check(folder.write("alone.gltf", GLTF), "buffers[0]: \"my%20data.bin\": cannot be read");
}

#[test]
fn understands_units_by_size() {
    let folder = Folder::new("units");
    let file = |side: &str| load(&folder.write("mesh.obj", OBJ.replace("0.2", side))).unwrap();
    let scale = |side: &str, unit| file(side).to_metres(unit).map(|(_, scaling)| scaling.metres_per_unit);
    for (side, expected) in [("0.02", 1.0), ("2", 1.0), ("20", 0.001), ("200", 0.001)] {
        assert_eq!(scale(side, Unit::Auto).unwrap(), expected);
    }
    for side in ["2.1", "19.9"] {
        let message = scale(side, Unit::Auto).unwrap_err().to_string();
        assert!(
            message.contains("mesh.obj") && message.contains(side) && message.contains("size_m"),
            "{message}"
        );
        assert_eq!(scale(side, Unit::Metres).unwrap(), 1.0);
    }
    assert_eq!(scale("1", Unit::Millimetres).unwrap(), 0.001);
    let (mesh, scaling) = file("8").to_metres(Unit::LongestSide(0.2)).unwrap();
    assert!((mesh.bounds().longest_side() - 0.2).abs() < 1e-15);
    assert_eq!(scaling.to_string(), "1 unit of the file is 0.025 m (as stated); longest side 0.2000 m");
    for side in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(scale("1", Unit::LongestSide(side)).is_err());
    }
}

/// Runs a parser; it must return, and any mesh that it accepts must pass through the checks.
fn survives(parse: fn(&[u8]) -> Result<RawMesh, SimError>, bytes: &[u8]) {
    if let Ok(raw) = parse(bytes) {
        assert!(raw.vertices.len() <= bytes.len() && raw.triangles.len() <= bytes.len());
        raw.check(bytes.len() as u64).ok();
    }
}

#[test]
fn a_valid_file_cut_anywhere_is_survived() {
    for (_, parse, valid) in formats() {
        (0..valid.len()).for_each(|n| survives(parse, &valid[..n]));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn garbage_is_survived(garbage in prop::collection::vec(any::<u8>(), 0..300)) {
        for (_, parse, _) in formats() {
            survives(parse, &garbage);
        }
    }

    #[test]
    fn garbage_after_a_valid_start_is_survived(
        cut in 0.0..1.0, garbage in prop::collection::vec(any::<u8>(), 0..100),
    ) {
        for (_, parse, valid) in formats() {
            let keep = (cut * valid.len() as f64) as usize;
            survives(parse, &[&valid[..keep], &garbage].concat());
        }
    }

    #[test]
    fn changed_bytes_are_survived(changes in prop::collection::vec((0.0..1.0, any::<u8>()), 1..6)) {
        for (_, parse, valid) in formats() {
            let mut bytes = valid.clone();
            for &(place, value) in &changes {
                bytes[(place * valid.len() as f64) as usize] = value;
            }
            survives(parse, &bytes);
        }
    }

    /// Parsers fail on numbers: every number of a text becomes an extreme one.
    #[test]
    fn extreme_numbers_are_survived(place in 0.0..1.0, number in prop::sample::select(vec![
        "-1", "0", "255", "4294967295", "4294967296", "9223372036854775807", "18446744073709551615",
        "99999999999999999999999", "1e308", "-1e999", "nan", "inf", "5125", "1152921504606846976",
    ])) {
        for (_, parse, valid) in formats() {
            let Ok(text) = String::from_utf8(valid) else { continue };
            let at = (place * text.len() as f64) as usize;
            let Some(start) = text[at..].find(|c: char| c.is_ascii_digit()).map(|i| at + i) else { continue };
            let length = text[start..].find(|c: char| !c.is_ascii_digit()).unwrap_or(text.len() - start);
            survives(parse, format!("{}{number}{}", &text[..start], &text[start + length..]).as_bytes());
        }
    }
}

#[test]
fn a_mesh_of_ours_reads_back_with_its_colours() {
    let mesh = crate::builtin::by_name("mug").unwrap();
    let (vertices, triangles) = (mesh.vertices().to_vec(), mesh.triangles().to_vec());
    let ours = nextview_model::SurfaceMesh { vertices, triangles };
    let mut points = ours.points();
    points.iter_mut().enumerate().for_each(|(i, point)| point.color = Some([i as u8, 2, 3]));
    let mut bytes = Vec::new();
    nextview_model::write_mesh(&mut bytes, &points, None, &ours.triangles).unwrap();
    let folder = Folder::new("ours");
    let (read, _) = load(&folder.write("mesh.ply", bytes)).unwrap().to_metres(Unit::Metres).unwrap();
    let singles: Vec<_> = ours.vertices.iter().map(|vertex| vertex.as_vec3().as_dvec3()).collect();
    assert!(read.vertices() == singles && read.triangles() == ours.triangles);
    let colors: Vec<[u8; 3]> = points.iter().filter_map(|point| point.color).collect();
    assert_eq!(read.appearance().unwrap().vertex_colors, colors);
}

/// The meshes of the test data, if present, with the face counts of their manifest.
#[test]
fn loads_the_meshes_of_the_test_data() {
    let Some(data) = nextview_checks::data("loads_the_meshes_of_the_test_data", "meshes") else { return };
    let manifest = std::fs::read_to_string(data.join("manifest.csv")).unwrap();
    for line in manifest.lines().skip(1) {
        let (name, rest) = line.split_once(',').unwrap();
        let faces = rest.split(',').find_map(|field| field.parse::<usize>().ok()).unwrap();
        let file = load(&data.join(name)).unwrap();
        assert_eq!(file.mesh().triangles().len() + file.n_dropped(), faces, "{name}");
    }
}
