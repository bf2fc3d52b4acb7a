//! Small files that stand for a lot: the program takes at most 20 times the file and 200 MB of memory, or
//! refuses with the value and the limit.

use crate::common::{Folder, Run, small};
use crate::recording::{SCAN, write_recording};
use nextview::geometry::VoxelKey;
use nextview_octomap::Octree;
use std::fs::{self, File};
use std::io::{BufWriter, Read, Write};
use std::process::Stdio;
use std::time::Duration;

/// Memory that a command may take whatever it reads, bytes.
const FREE: u64 = 200_000_000;

impl Folder {
    /// Runs a command that reads this file, or the files of this folder; returns its run, whose memory was
    /// within the bound.
    fn within_bound(&self, args: &[&str], file: &str) -> Run {
        let bound = FREE + 20 * size(&self.path(file));
        // A slightly larger address space: memory that is reserved but unused does not count, but a peak
        // between two measurements ends the program.
        let kilobytes = bound / 1000 + 600_000;
        let script = format!("ulimit -v {kilobytes}; exec \"$0\" \"$@\"");
        let mut command = std::process::Command::new("bash");
        command.args(["-c", &script, env!("CARGO_BIN_EXE_nextview")]).args(args);
        command.args(["--threads", "2"]).current_dir(self.path(".")).env("MALLOC_ARENA_MAX", "1");
        let (run, peak) = measured(command);
        assert!(matches!(run.code, Some(0..=2)), "{args:?}: {:?} {}", run.code, run.stderr);
        assert!(peak <= bound, "{args:?}: {} MB, expected at most {}", peak / 1_000_000, bound / 1_000_000);
        println!(
            "{file}: {} bytes, {} MB of {}: {}",
            size(&self.path(file)),
            peak / 1_000_000,
            bound / 1_000_000,
            run.stderr.lines().next().unwrap_or("done")
        );
        run
    }

    /// Runs the command within the same bound; it must refuse with a message that has all these parts.
    fn refuses_bomb(&self, args: &[&str], file: &str, parts: &[&str]) {
        let run = self.within_bound(args, file);
        assert_eq!((run.code, run.stdout.as_str()), (Some(1), ""), "{args:?}: {}", run.stderr);
        for part in parts {
            assert!(run.stderr.contains(part), "{args:?}: expected {part:?} in {}", run.stderr);
        }
    }
}

fn size(path: &std::path::Path) -> u64 {
    match fs::read_dir(path) {
        Ok(entries) => entries.map(|entry| size(&entry.unwrap().path())).sum(),
        Err(_) => path.metadata().unwrap().len(),
    }
}

/// Runs a command and measures its peak memory again and again, bytes.
fn measured(mut command: std::process::Command) -> (Run, u64) {
    let mut child =
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let status = format!("/proc/{}/status", child.id());
    let (mut stdout, mut stderr) = (child.stdout.take().unwrap(), child.stderr.take().unwrap());
    let read = |stream: &mut dyn Read| {
        let mut text = String::new();
        stream.read_to_string(&mut text).unwrap();
        text
    };
    let stdout = std::thread::spawn(move || read(&mut stdout));
    let stderr = std::thread::spawn(move || read(&mut stderr));
    let mut peak = 0;
    let code = loop {
        let text = fs::read_to_string(&status).unwrap_or_default();
        let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let kilobytes = line.and_then(|line| line.trim().strip_suffix(" kB")?.parse::<u64>().ok());
        peak = peak.max(1024 * kilobytes.unwrap_or(0));
        if let Some(status) = child.try_wait().unwrap() {
            break status.code();
        }
        std::thread::sleep(Duration::from_micros(200));
    };
    (Run { code, stdout: stdout.join().unwrap(), stderr: stderr.join().unwrap() }, peak)
}

/// A record of an MCAP file.
fn record(opcode: u8, content: &[u8]) -> Vec<u8> {
    [&[opcode][..], &(content.len() as u64).to_le_bytes(), content].concat()
}

/// A chunk that states `plain` bytes.
fn chunk(compression: &str, packed: &[u8], plain: u64) -> Vec<u8> {
    let mut content = vec![0; 16];
    content.extend(plain.to_le_bytes());
    content.extend([0; 4]);
    content.extend((compression.len() as u32).to_le_bytes());
    content.extend(compression.as_bytes());
    content.extend((packed.len() as u64).to_le_bytes());
    content.extend(packed);
    record(0x06, &content)
}

fn mcap(records: &[u8]) -> Vec<u8> {
    [b"\x89MCAP0\r\n", records, &record(0x0f, &[0; 4])].concat()
}

/// Zstandard (RFC 8878): `n_blocks` blocks of this size, at most 128 KiB, that repeat one byte.
fn zstd_of_zeros(n_blocks: u32, size: u32) -> Vec<u8> {
    // No single segment, no check sum; a window of 128 KiB.
    let mut frame = vec![0x28, 0xb5, 0x2f, 0xfd, 0x00, 0x38];
    for i in 0..n_blocks {
        let head = size << 3 | 1 << 1 | u32::from(i + 1 == n_blocks);
        frame.extend(&head.to_le_bytes()[..3]);
        frame.push(0);
    }
    frame
}

#[test]
fn chunks_of_a_recording() {
    let folder = Folder::new("bomb-mcap");
    let scan = ["scan", "--frames", "bomb.mcap"];
    // 197 KB for 6.4 GB, and the sizes that the file states are true.
    let packed = zstd_of_zeros(49_000, 128 * 1024);
    folder.write("bomb.mcap", mcap(&chunk("zstd", &packed, 49_000 * 128 * 1024)));
    let parts = [
        "bomb.mcap: record at byte 8: a chunk states 6422528000 bytes for 196006 compressed ones",
        "expected at most 35122480",
    ];
    folder.refuses_bomb(&scan, "bomb.mcap", &parts);
    // The chunk states a small size.
    folder.write("bomb.mcap", mcap(&chunk("zstd", &packed, 1000)));
    folder.refuses_bomb(&scan, "bomb.mcap", &["a chunk is damaged: 1001 bytes"]);
    // Many chunks, each within the limit, of meaningless records of nine bytes.
    let one = chunk("zstd", &zstd_of_zeros(256, 9 * 14_000), 256 * 9 * 14_000);
    folder.write("bomb.mcap", mcap(&one.repeat(200)));
    folder.refuses_bomb(
        &scan,
        "bomb.mcap",
        &["its chunks have 109670", " bytes so far, expected at most 10876"],
    );
    // A frame of LZ4 that repeats one byte: blocks of 4 MiB in 16 KB.
    let mut encoder = lz4_flex_frame();
    let block = vec![0; 1 << 22];
    (0..100).for_each(|_| encoder.write_all(&block).unwrap());
    let packed = encoder.finish().unwrap();
    folder.write("bomb.mcap", mcap(&chunk("lz4", &packed, 100 << 22)));
    folder.refuses_bomb(&scan, "bomb.mcap", &["a chunk states 419430400 bytes for", "expected at most"]);
}

fn lz4_flex_frame() -> lz4_flex::frame::FrameEncoder<Vec<u8>> {
    let block = lz4_flex::frame::BlockSize::Max4MB;
    lz4_flex::frame::FrameEncoder::with_frame_info(
        lz4_flex::frame::FrameInfo::new().block_size(block),
        Vec::new(),
    )
}

#[test]
fn messages_of_a_recording() {
    let folder = Folder::new("bomb-messages");
    let text = |text: &str| [&(text.len() as u32).to_le_bytes()[..], text.as_bytes()].concat();
    let names = |topic: &str| {
        let schema = [&[1, 0][..], &text("geometry_msgs/msg/PoseStamped")].concat();
        let channel = [&[1, 0, 1, 0][..], &text(topic), &text("cdr")].concat();
        [record(0x03, &schema), record(0x04, &channel)].concat()
    };
    // Each takes a hundred bytes, and almost none when compressed.
    let pose =
        [&[0, 1, 0, 0][..], &[0; 8], &1_u32.to_le_bytes(), &[0; 4], &[0; 48], &1_f64.to_le_bytes()].concat();
    let message = record(0x05, &[&[1, 0][..], &[0; 20], &pose].concat());
    let plain = [names("/pose"), message.repeat(300_000)].concat();
    let mut encoder = lz4_flex_frame();
    encoder.write_all(&plain).unwrap();
    let packed = encoder.finish().unwrap();
    folder.write("bomb.mcap", mcap(&chunk("lz4", &packed, plain.len() as u64)));
    folder.refuses_bomb(
        &["scan", "--frames", "bomb.mcap"],
        "bomb.mcap",
        &["bomb.mcap: ", "expected at most"],
    );
    // Every message has the name of the topic.
    folder.write("bomb.mcap", mcap(&names(&"/t".repeat(1_000_000))));
    let parts = ["a name has 2000000 bytes, expected at most 256"];
    folder.refuses_bomb(&["scan", "--frames", "bomb.mcap"], "bomb.mcap", &parts);
}

/// Writes an empty image, row by row.
fn write_png(folder: &Folder, name: &str, side: u32, color: png::ColorType, depth: png::BitDepth) {
    let file = BufWriter::new(File::create(folder.path(name)).unwrap());
    let mut encoder = png::Encoder::new(file, side, side);
    encoder.set_color(color);
    encoder.set_depth(depth);
    let mut writer = encoder.write_header().unwrap();
    let mut stream = writer.stream_writer().unwrap();
    let samples = if color == png::ColorType::Rgb { 3 } else { 1 };
    let row = vec![0; samples * side as usize * depth as usize / 8];
    (0..side).for_each(|_| stream.write_all(&row).unwrap());
    stream.finish().unwrap();
}

#[test]
fn images_of_a_recording() {
    let folder = Folder::new("bomb-png");
    write_recording(&folder, 3);
    fs::create_dir(folder.path("rec/color")).unwrap();
    write_png(&folder, "rec/color/001.png", 8192, png::ColorType::Rgb, png::BitDepth::Eight);
    folder.refuses_bomb(
        &SCAN,
        "rec",
        &["color/001.png: the colour image has 8192 x 8192 pixels, expected the size"],
    );
    fs::remove_dir_all(folder.path("rec/color")).unwrap();
    for i in 0..3 {
        write_png(
            &folder,
            &format!("rec/depth/00{i}.png"),
            16384,
            png::ColorType::Grayscale,
            png::BitDepth::Sixteen,
        );
    }
    folder.write("rec/intrinsics.txt", "width 16384\nheight 16384\nfx 150\nfy 150\ncx 79.5\ncy 59.5\n");
    let parts =
        ["rec: the images have 16384 x 16384 = 268435456 pixels, expected at most ", " in 3 images of "];
    folder.refuses_bomb(&SCAN, "rec", &parts);
}

#[test]
fn the_largest_images_that_are_accepted() {
    let folder = Folder::new("bomb-large-png");
    write_recording(&folder, 10);
    let (width, height) = (1280, 720);
    // Near the camera, at slightly different depths: every pixel is mapped.
    let row = |v: u32| (0..width).flat_map(move |u| (300 + (u / 256 + v / 256) as u16).to_be_bytes());
    let pixels: Vec<u8> = (0..height).flat_map(row).collect();
    let image = crate::recording::png(width, height, png::BitDepth::Sixteen, &pixels);
    (0..10).for_each(|i| folder.write(&format!("rec/depth/00{i}.png"), &image));
    folder.write("rec/intrinsics.txt", "width 1280\nheight 720\nfx 1100\nfy 1100\ncx 640\ncy 360\n");
    let run = folder.within_bound(&[&SCAN[..], &["--planner=in-order", "--json"]].concat(), "rec");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
}

#[test]
fn lists_of_a_recording() {
    let folder = Folder::new("bomb-lists");
    write_recording(&folder, 3);
    let poses = folder.text("rec/poses.csv");
    folder.write("rec/poses.csv", ",".repeat(30_000_000));
    folder.refuses_bomb(&SCAN, "rec", &["poses.csv: line 1: is longer than 65536 bytes"]);
    folder.write("rec/poses.csv", poses);
    fs::create_dir(folder.path("tum")).unwrap();
    folder.write("tum/intrinsics.txt", folder.text("rec/intrinsics.txt"));
    folder.write("tum/groundtruth.txt", "1 0 0 0 0 0 0 1\n");
    let lines: String = (0..2_000_000).map(|i| format!("{i} a\n")).collect();
    folder.write("tum/depth.txt", lines);
    let parts = ["depth.txt: holds 2000000 entries in 18888890 bytes, expected at most "];
    folder.refuses_bomb(&["scan", "--frames", "tum"], "tum", &parts);
}

/// A glTF file with one mesh in many places.
fn gltf(nodes: &str, scene: &str, n_triangles: usize) -> String {
    let n_bytes = 36 + 12 * n_triangles;
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[{scene}]}}],"nodes":[{nodes}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1}}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}},
            {{"bufferView":0,"byteOffset":36,"componentType":5125,"count":{},"type":"SCALAR"}}],
        "bufferViews":[{{"buffer":0,"byteLength":{n_bytes}}}],
        "buffers":[{{"uri":"data.bin","byteLength":{n_bytes}}}]}}"#,
        3 * n_triangles
    )
}

fn gltf_data(n_triangles: usize) -> Vec<u8> {
    let corners = [0_f32, 0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 0.1, 0.0];
    let mut bytes: Vec<u8> = corners.iter().flat_map(|x| x.to_le_bytes()).collect();
    (0..n_triangles).for_each(|_| bytes.extend([0_u32, 1, 2].iter().flat_map(|i| i.to_le_bytes())));
    bytes
}

#[test]
fn meshes_in_many_places() {
    let folder = Folder::new("bomb-gltf");
    fs::create_dir(folder.path("m")).unwrap();
    let list = |entry: &dyn Fn(usize) -> String, n: usize| (0..n).map(entry).collect::<Vec<_>>().join(",");
    let scan = ["scan", "m/a.gltf"];
    folder.write("m/data.bin", gltf_data(100_000));
    folder.write(
        "m/a.gltf",
        gltf(&list(&|_| r#"{"mesh":0}"#.into(), 990), &list(&|i| i.to_string(), 990), 100_000),
    );
    let parts = ["a.gltf: mesh: ", " triangles in 12", " MB, more than the limit of 12", "20 times the file"];
    folder.refuses_bomb(&scan, "m", &parts);
    // Empty nodes, and one node again and again.
    folder.write("m/data.bin", gltf_data(1));
    folder.write("m/a.gltf", gltf(&list(&|_| "{}".into(), 3_000_000), "0", 1));
    folder.refuses_bomb(
        &scan,
        "m",
        &["a.gltf: JSON line 1: invalid length 200001, expected a list of at most 200000"],
    );
    folder.write("m/a.gltf", gltf("{}", &list(&|_| "0".into(), 5_000_000), 1));
    folder.refuses_bomb(&scan, "m", &["a.gltf: nodes[0]: is reached twice"]);
    let again = r#"{"uri":"data.bin","byteLength":48}"#;
    let buffers = |text: String| text.replace(again, &list(&|_| again.to_owned(), 1000));
    folder.write("m/data.bin", [gltf_data(1), vec![0; 1_000_000]].concat());
    folder.write("m/a.gltf", buffers(gltf(r#"{"mesh":0}"#, "0", 1)));
    folder.refuses_bomb(&scan, "m", &["a.gltf: buffers[1]: ", "names a file that was already read"]);
}

#[test]
fn meshes_of_polygons() {
    let folder = Folder::new("bomb-ply");
    let n = 20_000_usize;
    let mut ply = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex 255\nproperty uchar x\nproperty uchar y\n\
         property uchar z\nelement face {n}\nproperty list uchar uchar vertex_indices\nend_header\n"
    )
    .into_bytes();
    // A ring, so that all triangles of a polygon have an area.
    let ring = (0..255_u32).map(|i| f64::from(i) / 255.0 * std::f64::consts::TAU);
    ply.extend(ring.flat_map(|a| [127.0 + 120.0 * a.cos(), 127.0 + 120.0 * a.sin(), a].map(|x| x as u8)));
    let polygon: Vec<u8> = std::iter::once(254).chain(0..254).collect();
    ply.extend(polygon.repeat(n));
    folder.write("a.ply", ply);
    let parts = ["a.ply: mesh: 255 vertices and 5", " triangles in 5100", "more than the limit of 20"];
    folder.refuses_bomb(&["scan", "a.ply"], "a.ply", &parts);
    let polygons = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf".to_owned() + &" 1 2 3".repeat(1_000_000);
    folder.write("a.obj", polygons);
    folder.refuses_bomb(&["scan", "a.obj"], "a.obj", &["a.obj: mesh: 3 vertices and 2999998 triangles"]);
}

/// The densest ordinary file of the maximum size: it stays within the bound and is scanned.
#[test]
fn a_mesh_near_the_limit() {
    let folder = Folder::new("bomb-large-mesh");
    let n = 600_u32;
    let height = |i: u32, j: u32| 0.02 * (f64::from(i) * 0.02).sin() * (f64::from(j) * 0.03).cos();
    let vertices = (0..n).flat_map(|i| (0..n).map(move |j| [f64::from(i), f64::from(j), height(i, j) * 2e3]));
    let vertices: Vec<u8> = vertices.flatten().flat_map(|x| ((x * 2e-4) as f32).to_le_bytes()).collect();
    let mut ply = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\n\
         property float z\nelement face {}\nproperty list uchar uint vertex_indices\nend_header\n",
        n * n,
        2 * (n - 1) * (n - 1)
    )
    .into_bytes();
    ply.extend(vertices);
    for (i, j) in (0..n - 1).flat_map(|i| (0..n - 1).map(move |j| (i, j))) {
        let at = i * n + j;
        for corners in [[at, at + 1, at + n], [at + 1, at + n + 1, at + n]] {
            ply.push(3);
            corners.iter().for_each(|corner| ply.extend(corner.to_le_bytes()));
        }
    }
    folder.write("a.ply", ply);
    let run = folder
        .within_bound(&["scan", "a.ply", "--unit=m", "--candidates=100", "--views=3", "--json"], "a.ply");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
}

#[test]
fn maps_of_merged_leaves() {
    let folder = Folder::new("bomb-maps");
    folder.write("views.csv", "0.4,0,0.1\n");
    let write = |name: &str, voxels: &[(VoxelKey, f32)]| {
        let mut bytes = Vec::new();
        Octree::from_voxels(0.001, voxels.iter().copied()).unwrap().write_ot(&mut bytes).unwrap();
        folder.write(name, bytes);
    };
    // Two voxels that are far apart.
    write("far.ot", &[(VoxelKey::new(-130, -130, -130), 0.85), (VoxelKey::new(130, 130, 130), 0.85)]);
    let parts = [
        "far.ot: planning in the box around its occupied voxels, from ",
        " MB, more than the limit of 181 MB",
        "hint: set --box to a cube around the object",
    ];
    folder.refuses_bomb(&["plan", "--map", "far.ot", "--views", "views.csv"], "far.ot", &parts);
    // A leaf of 2^24 voxels, in 300 bytes.
    let mut bytes = Vec::new();
    Octree::from_voxels(0.001, [(VoxelKey::ZERO, 0.85)]).unwrap().write_ot(&mut bytes).unwrap();
    let at = bytes.windows(6).position(|window| window == b"\ndata\n").unwrap() + 6;
    let head = String::from_utf8(bytes[..at].to_vec()).unwrap().replace("size 17", "size 9");
    let mut nodes = bytes[at..at + 9 * 5].to_vec();
    nodes[44] = 0;
    folder.write("leaf.ot", [head.as_bytes(), &nodes].concat());
    let info = folder.within_bound(&["map", "info", "leaf.ot"], "leaf.ot");
    assert!(info.stdout.contains("occupied voxels  16777216"), "{info:?}");
    for to in ["leaf.ply", "leaf.bt"] {
        let run = folder.within_bound(&["map", "convert", "leaf.ot", to], "leaf.ot");
        assert_eq!(run.code, Some(0), "{}", run.stderr);
    }
    assert!(folder.path("leaf.ply").metadata().unwrap().len() > 12 * 16_777_216);
    folder.refuses_bomb(
        &["plan", "--map", "leaf.ot", "--views", "views.csv"],
        "leaf.ot",
        &["around its occupied"],
    );
    let with_box = ["plan", "--map", "leaf.ot", "--views", "views.csv", "--box=0,0,0,0.02"];
    let run = folder.within_bound(&with_box, "leaf.ot");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
}

#[test]
fn files_without_end() {
    let folder = Folder::new("bomb-sparse");
    folder.ok(&small(&["--views", "1", "--baselines", "off"]));
    // A sparse file of 100 GB takes no space on the disk.
    let holes = ["hole", "hole.ply", "hole.obj"];
    holes.iter().for_each(|hole| File::create(folder.path(hole)).unwrap().set_len(100_000_000_000).unwrap());
    fs::create_dir(folder.path("runs")).unwrap();
    fs::hard_link(folder.path("hole"), folder.path("runs/runs.jsonl")).unwrap();
    // The bound is that of an empty file.
    folder.write("none", "");
    let bytes = "100000000000 bytes, expected at most ";
    folder.refuses_bomb(
        &["scan", "--config", "hole"],
        "none",
        &["hole: cannot be read: it has ", bytes, "1048576"],
    );
    folder.refuses_bomb(&["bench", "hole"], "none", &["hole: cannot be read: it has ", bytes, "4194304"]);
    for mesh in &holes[1..] {
        folder.refuses_bomb(&["scan", mesh], "none", &[mesh, bytes, "4294967296"]);
    }
    folder.refuses_bomb(
        &["scan", "builtin:mug", "--view-space", "hole"],
        "none",
        &["hole: byte 67108864: the file goes on, expected at most 67108864 bytes"],
    );
    let plan = ["plan", "--map", "out/map.ot", "--views", "hole"];
    folder.refuses_bomb(
        &plan,
        "none",
        &["hole: byte 67108864: the file goes on, expected at most 67108864 bytes"],
    );
    folder.refuses_bomb(&["map", "info", "hole"], "none", &["hole: line 1: longer than 4096 bytes"]);
    folder.refuses_bomb(
        &["report", "runs"],
        "none",
        &["runs.jsonl, line 1, column 1: is longer than 67108864 bytes"],
    );
    folder.refuses_bomb(&["scan", "--frames", "hole"], "none", &["hole: is not an MCAP file"]);
}

#[test]
fn views_by_the_million() {
    let folder = Folder::new("bomb-views");
    folder.ok(&small(&["--views", "1", "--baselines", "off"]));
    folder.write("views.csv", "0.4,0,0\n".repeat(1_000_000));
    let plan = ["plan", "--map", "out/map.ot", "--views", "views.csv", "--planner", "random"];
    let run = folder.within_bound(&plan, "views.csv");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
}

#[test]
fn records_of_a_campaign() {
    let folder = Folder::new("bomb-runs");
    let steps = vec!["{}"; 2_000_000].join(",");
    folder.write("a/runs.jsonl", format!("{{\"result\":{{\"done\":{{\"steps\":[{steps}]}}}}}}\n"));
    let parts = ["runs.jsonl, line 1, column 1: 2000003 objects in 60000", "expected the record of a run"];
    folder.refuses_bomb(&["report", "a"], "a", &parts);
}
