//! A synthetic recording: frames of a mug by a simulated camera.

use crate::common::Folder;
use glam::{DVec2, DVec3};
use nextview::sensor::{Depth, Intrinsics};
use nextview::view::generate;
use nextview_recording::{ReadOptions, Recording};
use nextview_sim::mesh::TriangleMesh;
use nextview_sim::{builtin, scene::Scene};

/// A scan of the recording in the folder `rec`; a test may run another one in the folder afterwards.
pub const SCAN: [&str; 7] = ["scan", "--frames", "rec", "--voxel-size-m", "0.01", "--force", "--out=out"];

/// Writes `n` frames into the folder `rec`, and the object that they show as `mug.obj` and, in another place,
/// as `moved.obj`.
pub fn write_recording(folder: &Folder, n: usize) {
    let camera = Intrinsics::pinhole(160, 120, DVec2::splat(150.0), DVec2::new(79.5, 59.5)).unwrap();
    let mesh = builtin::by_name("mug").unwrap();
    folder.write("mug.obj", obj(&mesh, |v| v));
    folder.write("moved.obj", obj(&mesh, |v| DVec3::new(0.3 - v.y, v.x - 0.2, v.z + 0.1)));
    let scene = Scene::new(mesh, camera).unwrap();
    let views = generate::shell(scene.center(), scene.size(), n, 0).unwrap();
    folder.write("rec/intrinsics.txt", "width 160\nheight 120\nfx 150\nfy 150\ncx 79.5\ncy 59.5\n");
    let entries: Vec<String> = (0..12).map(|i| format!("world_from_camera_{}{}", i / 4, i % 4)).collect();
    let mut poses = format!("frame,{}\n", entries.join(","));
    for (i, pose) in views.poses().iter().enumerate() {
        let frame = scene.camera().capture(pose).unwrap();
        let pixels = (0..120).flat_map(|v| (0..160).map(move |u| (u, v)));
        let millimetres = pixels.map(|(u, v)| match frame.image().get(u, v) {
            Depth::Surface(depth) => (1e3 * depth).round() as u16,
            _ => 0,
        });
        let bytes: Vec<u8> = millimetres.flat_map(u16::to_be_bytes).collect();
        folder.write(&format!("rec/depth/{i:03}.png"), png(160, 120, png::BitDepth::Sixteen, &bytes));
        let (m, t) = (pose.rotation_matrix().transpose(), pose.translation());
        let row = [m.x_axis.extend(t.x), m.y_axis.extend(t.y), m.z_axis.extend(t.z)].map(|r| r.to_array());
        let row: Vec<String> = row.concat().iter().map(f64::to_string).collect();
        poses += &format!("{i},{}\n", row.join(","));
    }
    folder.write("rec/poses.csv", poses);
}

/// Adds colour images that show where in the world everything is.
pub fn write_colors(folder: &Folder, n: usize) {
    let recording = Recording::open(&folder.path("rec"), &ReadOptions::default()).unwrap();
    for (i, frame) in recording.frames.iter().enumerate().take(n) {
        let frame = frame.load().unwrap();
        let pixels = (0..120).flat_map(|v| (0..160).map(move |u| (u, v)));
        let colors = pixels.map(|(u, v)| match frame.image().get(u, v) {
            Depth::Surface(depth) => {
                let ideal = frame.intrinsics().deproject(DVec2::new(u as f64, v as f64)).unwrap();
                color_at(frame.world_from_camera().transform_point(ideal.extend(1.0) * depth as f64))
            }
            _ => [0; 3],
        });
        let bytes: Vec<u8> = colors.flatten().collect();
        folder.write(&format!("rec/color/{i:03}.png"), color_png(160, 120, &bytes));
    }
}

/// The colour that stands for a place: a step is 2 mm.
pub fn color_at(place: DVec3) -> [u8; 3] {
    (place * 500.0 + 128.0).to_array().map(|value| value.round().clamp(0.0, 255.0) as u8)
}

fn color_png(width: u32, height: u32, bytes: &[u8]) -> Vec<u8> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header().unwrap().write_image_data(bytes).unwrap();
    file
}

/// A PNG image without colour.
pub fn png(width: u32, height: u32, bits: png::BitDepth, bytes: &[u8]) -> Vec<u8> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, width, height);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(bits);
    encoder.write_header().unwrap().write_image_data(bytes).unwrap();
    file
}

fn obj(mesh: &TriangleMesh, place: impl Fn(DVec3) -> DVec3) -> String {
    let vertex = |v: &DVec3| place(*v).to_array().map(|x| x.to_string()).join(" ");
    let vertices: String = mesh.vertices().iter().map(|v| format!("v {}\n", vertex(v))).collect();
    let face = |t: &[u32; 3]| t.map(|i| (i + 1).to_string()).join(" ");
    vertices + &mesh.triangles().iter().map(|t| format!("f {}\n", face(t))).collect::<String>()
}
