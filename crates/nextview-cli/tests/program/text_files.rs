//! Every reader of texts accepts files as any editor saves them, or reports what is wrong with them.

use crate::common::Folder;
use nextview::geometry::Pose;
use nextview::sensor::{DepthImage, Frame, Intrinsics};
use nextview::view::ViewSpace;
use nextview_campaign::Spec;
use nextview_learned::dataset::{self, DatasetConfig, NetworkName};
use nextview_recording::{NumberedFrame, ReadOptions, Recording, read_transform, write_folder};
use nextview_scan::{RobotConfig, ScanConfig, ScanRecord};
use nextview_sim::mesh;
use std::fmt::{Debug, Display};
use std::path::Path;

/// A text in a folder, and its reader.
struct Reader {
    file: &'static str,
    text: String,
    /// Words that may be in capitals.
    words: &'static [&'static str],
    /// Whether a backslash continues a line.
    continues: bool,
    /// Reads the file at this path, and returns its content as text.
    read: fn(&Path) -> Result<String, String>,
}

fn reader(
    file: &'static str,
    text: impl Into<String>,
    words: &'static [&'static str],
    read: fn(&Path) -> Result<String, String>,
) -> Reader {
    let continues = file.ends_with(".obj") || file.ends_with(".mtl");
    Reader { file, text: text.into(), words, continues, read }
}

/// The result of a reader, as text.
fn shown<T: Debug>(read: Result<T, impl Display>) -> Result<String, String> {
    read.map(|value| format!("{value:?}")).map_err(|error| error.to_string())
}

fn of_mesh(path: &Path) -> Result<String, String> {
    let file = mesh::load(path).map_err(|error| error.to_string())?;
    match file.color_fault() {
        Some(fault) => Err(fault.to_string()),
        None => shown(file.to_metres(mesh::Unit::Metres)),
    }
}

fn of_recording(path: &Path) -> Result<String, String> {
    shown(Recording::open(path.parent().unwrap(), &ReadOptions::default()))
}

fn of_robot(path: &Path) -> Result<String, String> {
    let config = RobotConfig { arm: path.to_string_lossy().into_owned(), ..RobotConfig::default() };
    shown(config.cell())
}

const RECORD: &str = "record/record.json";

fn readers(folder: &Folder) -> Vec<Reader> {
    let text = |name: &str| folder.text(name);
    vec![
        reader(
            "part.obj",
            "mtllib part.mtl\nv 0 0 0\nv 0.1 0 0\nv 0.1 0.1 0\nv 0 0.1 0\nvt 0 0\nusemtl red\nf 1/1 2/1 3/1 4/1\n",
            &["v ", "vt ", "f ", "mtllib", "usemtl"],
            of_mesh,
        ),
        reader("part.mtl", "newmtl red\nKd 1 0 0.5\n", &["newmtl", "Kd"], |path| {
            of_mesh(&path.with_extension("obj"))
        }),
        reader(
            "part.off",
            "OFF\n4 2 0\n0 0 0\n0.1 0 0\n0.1 0.1 0\n0 0.1 0.1\n3 0 1 2\n3 0 2 3\n",
            &["OFF"],
            of_mesh,
        ),
        reader(
            "part.stl",
            "solid part\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 0.1 0 0\nvertex 0 0.1 0\nendloop\n\
             endfacet\nendsolid part\n",
            &["solid", "facet normal", "outer loop", "vertex", "endloop", "endfacet", "endsolid"],
            of_mesh,
        ),
        reader(
            "part.ply",
            "ply\nformat ascii 1.0\ncomment ä\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
             property uchar red\nproperty uchar green\nproperty uchar blue\nelement face 1\n\
             property list uchar int vertex_indices\nend_header\n0 0 0 1 2 3\n0.1 0 0 4 5 6\n0 0.1 0 7 8 9\n3 0 1 2\n",
            &[
                "ply",
                "format ascii",
                "comment",
                "element",
                "property",
                "float",
                "red",
                "face",
                "vertex",
                "end_header",
            ],
            of_mesh,
        ),
        reader(
            "part.gltf",
            r#"{"asset": {"version": "2.0"},
"scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
"meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
"accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
"bufferViews": [{"buffer": 0, "byteLength": 36}],
"buffers": [{"byteLength": 36, "uri": "data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]}
"#,
            &["\"asset\"", "\"POSITION\""],
            of_mesh,
        ),
        reader(
            "views.csv",
            "x_m,y_m,z_m,qx,qy,qz,qw\n0.1,0.2,0.3,0,0,0,1\n0.4,0.5,0.6,0,0,1,0\n",
            &["x_m", "qx", "qy", "qz", "qw"],
            |path| {
                let file = std::fs::File::open(path).unwrap();
                shown(ViewSpace::read_csv(file, glam::DVec3::ZERO))
            },
        ),
        reader("hand-eye.txt", "1 0 0 0.1\n0 1 0 0.2\n0 0 1 0.3\n0 0 0 1\n", &[], |path| {
            shown(read_transform(path))
        }),
        reader(
            "frames/intrinsics.txt",
            text("frames/intrinsics.txt"),
            &["width", "fx", "depth_unit_m"],
            of_recording,
        ),
        reader(
            "frames/poses.csv",
            text("frames/poses.csv"),
            &["frame", "timestamp_s", "world_from_camera"],
            of_recording,
        ),
        reader("tum/intrinsics.txt", text("frames/intrinsics.txt"), &["height", "cy"], of_recording),
        reader(
            "tum/groundtruth.txt",
            "# poses\n1.5 0 0 0.3 0 0 0 1\n2.5 0 0.1 0.3 0 0 0 1\n",
            &[],
            of_recording,
        ),
        reader("tum/depth.txt", "# images\n1.5 depth/000.png\n2.5 depth/001.png\n", &["depth"], of_recording),
        reader("tum/rgb.txt", "# colours\n1.5 rgb/000.png\n", &[], of_recording),
        reader(
            "scan.toml",
            "voxel_size_m = 0.01\n\n[stop]\ncompleteness = 0.9\n",
            &["voxel_size_m", "stop"],
            |path| shown(ScanConfig::load(path, None)),
        ),
        reader("sensor.toml", "like = \"d435i\"\n\n[camera]\nwidth = 640\n", &["like", "width"], |path| {
            let name = format!("sensor = {:?}\n", path.to_string_lossy());
            shown(ScanConfig::parse(&name, None, None))
        }),
        reader(
            "campaign.toml",
            "name = \"c\"\nobjects = [\"builtin:mug\"]\n\n[scan]\nplanner = \"random\"\n",
            &["objects"],
            |path| shown(Spec::load(&path.to_string_lossy(), &[])),
        ),
        reader(RECORD, text(RECORD), &["\"steps\""], |path| shown(ScanRecord::read(path.parent().unwrap()))),
        reader("data/dataset.toml", text("data/dataset.toml"), &["network"], |path| {
            let config = DatasetConfig { network: NetworkName::NbvNet, objects: 0, seed: 7 };
            shown(dataset::make(&config, path.parent().unwrap(), true, || ()))
        }),
        reader(
            "arm.urdf",
            "<robot name=\"a\"><link name=\"base\"/>\n<link name=\"tip\"><collision><geometry>\n<sphere radius=\"0.1\"/>\
             </geometry></collision></link>\n<joint name=\"j\" type=\"revolute\"><parent link=\"base\"/><child link=\"tip\"/>\
             <origin xyz=\"0 0 1\"/>\n<axis xyz=\"0 0 1\"/><limit lower=\"-1\" upper=\"1\" velocity=\"1\" effort=\"1\"/>\
             </joint></robot>\n",
            &["collision", "origin", "axis", "xyz", "sphere", "limit", "velocity", "radius", "geometry"],
            of_robot,
        ),
    ]
}

/// A folder with all texts, and the files to which they refer.
fn folder() -> Folder {
    let folder = Folder::new("text-files");
    let camera = Intrinsics::d435i();
    let depth = (0..camera.n_pixels()).map(|i| 0.3 + 0.001 * (i % 50) as f32).collect();
    let image = DepthImage::from_metres(camera.width(), camera.height(), depth).unwrap();
    let frame = Frame::new(image, camera, Pose::IDENTITY, 1.0).unwrap();
    let frames = [3, 5].map(|number| NumberedFrame { number, frame: &frame });
    let keep = |name: &str, bytes: Vec<u8>| {
        folder.write(&format!("frames/{name}"), bytes);
        Ok::<_, std::convert::Infallible>(())
    };
    write_folder(&frames, |_| Ok(None), keep).unwrap();
    // A known, optional column.
    let poses = folder.text("frames/poses.csv").lines().enumerate().fold(String::new(), |text, (i, line)| {
        let time = if i == 0 { "timestamp_s".to_owned() } else { format!("{i}.5") };
        format!("{text}{time},{line}\n")
    });
    folder.write("frames/poses.csv", poses);
    for (i, image) in ["frames/depth/003.png", "frames/depth/005.png"].iter().enumerate() {
        folder.write(&format!("tum/depth/00{i}.png"), folder.bytes(image));
    }
    let color = nextview::sensor::ColorImage::new(640, 480, vec![[1, 2, 3]; 640 * 480]).unwrap();
    folder.write("tum/rgb/000.png", nextview_recording::encode_color(&color));
    let scanned = folder.run(&[
        "scan",
        "builtin:mug",
        "--views=1",
        "--candidates=10",
        "--voxel-size-m=0.02",
        "--out=record",
    ]);
    assert_eq!(scanned.code, Some(0), "{}", scanned.stderr);
    let data = DatasetConfig { network: NetworkName::NbvNet, objects: 0, seed: 7 };
    dataset::make(&data, &folder.path("data"), false, || ()).unwrap();
    folder
}

fn utf16(text: &str, to_bytes: fn(u16) -> [u8; 2]) -> Vec<u8> {
    text.encode_utf16().flat_map(to_bytes).collect()
}

#[test]
fn every_text_is_read_as_any_editor_saves_it() {
    const MARK: &str = "\u{feff}";
    let folder = folder();
    let readers = readers(&folder);
    readers.iter().for_each(|reader| folder.write(reader.file, &reader.text));
    let mut faults = Vec::new();
    for Reader { file, text, words, continues, read } in &readers {
        let read_as = |bytes: &[u8]| {
            folder.write(file, bytes);
            read(&folder.path(file))
        };
        let expected = read_as(text.as_bytes());
        if let Err(error) = &expected {
            faults.push(format!("{file}: {error}"));
            continue;
        }
        let crlf = text.replace('\n', "\r\n");
        let mut same = vec![
            ("byte order mark", format!("{MARK}{text}")),
            ("CR LF", crlf.clone()),
            ("CR LF and byte order mark", format!("{MARK}{crlf}")),
            ("CR", text.replace('\n', "\r")),
            ("no last line end", text.trim_end().to_owned()),
        ];
        if *continues {
            same.push(("continued lines", text.replace(' ', " \\\n ")));
            same.push(("continued lines, CR LF", text.replace(' ', " \\\r\n")));
            same.push(("continued lines, CR", text.replace(' ', " \\\r")));
        }
        for (variant, bytes) in same {
            let found = read_as(bytes.as_bytes());
            if found != expected {
                faults.push(format!("{file}, {variant}: {found:?}"));
            }
        }
        // Capitals are read as small letters, or reported.
        for word in words.iter() {
            assert!(text.contains(word), "{file} has no {word}");
            let found = read_as(text.replace(word, &word.to_uppercase()).as_bytes());
            let is_told = found.as_ref().is_err_and(|error| !error.is_empty());
            if found != expected && !is_told {
                faults.push(format!("{file}, {word} in capitals: {found:?}"));
            }
        }
        let refused = [
            ("UTF-16", utf16(&format!("{MARK}{text}"), u16::to_le_bytes)),
            ("UTF-16", utf16(&format!("{MARK}{text}"), u16::to_be_bytes)),
            ("UTF-16", utf16(text, u16::to_le_bytes)),
            ("UTF-16", utf16(text, u16::to_be_bytes)),
            ("byte order mark", format!("{MARK}{text}{MARK}{text}").into_bytes()),
        ];
        for (i, (cause, bytes)) in refused.iter().enumerate() {
            match read_as(bytes) {
                Err(error) if error.contains(cause) => {}
                other => faults.push(format!("{file}, refused text {i}: {other:?} does not name {cause}")),
            }
        }
        folder.write(file, text);
    }
    assert!(faults.is_empty(), "{} faults\n{}", faults.len(), faults.join("\n"));
}
