//! A synthetic recording, and the folders that hold it.

use glam::{DMat3, DVec2};
use nextview::geometry::Pose;
use nextview::sensor::{Depth, DepthImage, Intrinsics};
use nextview::view::generate;
use nextview_recording::{ReadOptions, Recording, RecordingError};
use nextview_sim::{builtin, scene::Scene};
use std::fs;
use std::path::{Path, PathBuf};

/// A folder that is removed at the end unless the test fails.
pub struct Folder(pub PathBuf);

impl Folder {
    /// The name must differ from those of all other tests of this crate.
    pub fn new(name: &str) -> Self {
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(env!("CARGO_PKG_NAME")).join(name);
        let _ = fs::remove_dir_all(&path);
        ["depth", "color", "rgb"].iter().for_each(|images| fs::create_dir_all(path.join(images)).unwrap());
        Self(path)
    }

    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        fs::write(self.0.join(name), content).unwrap();
    }

    pub fn text(&self, name: &str) -> String {
        fs::read_to_string(self.0.join(name)).unwrap()
    }

    /// Writes a file anew with another text in place of the first of this one, which must be there.
    pub fn replace(&self, name: &str, from: &str, to: &str) {
        let text = self.text(name);
        assert!(text.contains(from), "{name} has no {from:?}");
        self.write(name, text.replacen(from, to, 1));
    }

    pub fn open(&self) -> Result<Recording, RecordingError> {
        Recording::open(&self.0, &ReadOptions::default())
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        if !std::thread::panicking() {
            let _ = fs::remove_dir_all(&self.0);
        }
    }
}

/// What a camera saw: depth in millimetres, 0 where there is none, and the poses.
pub struct SyntheticRecording {
    pub camera: Intrinsics,
    pub poses: Vec<Pose>,
    pub images: Vec<Vec<u16>>,
}

impl SyntheticRecording {
    /// Looks at a mug in a room.
    pub fn new(n: usize) -> Self {
        let camera = Intrinsics::pinhole(80, 60, DVec2::splat(75.0), DVec2::new(39.5, 29.5)).unwrap();
        let scene = Scene::new(builtin::by_name("mug").unwrap(), camera).unwrap();
        let views = generate::shell(scene.center(), scene.size(), n, 0).unwrap();
        let look = |pose: &Pose| millimetres(scene.camera().capture(pose).unwrap().image());
        Self { camera, poses: views.poses().to_vec(), images: views.poses().iter().map(look).collect() }
    }

    /// The camera as intrinsics.txt states it.
    pub fn intrinsics(&self) -> String {
        let Self { camera, .. } = self;
        let (f, c) = (camera.focal(), camera.center());
        format!(
            "width {}\nheight {}\nfx {}\nfy {}\ncx {}\ncy {}\n",
            camera.width(),
            camera.height(),
            f.x,
            f.y,
            c.x,
            c.y
        )
    }

    pub fn png(&self, i: usize) -> Vec<u8> {
        let bytes: Vec<u8> = self.images[i].iter().flat_map(|mm| mm.to_be_bytes()).collect();
        png(
            self.camera.width(),
            self.camera.height(),
            png::ColorType::Grayscale,
            png::BitDepth::Sixteen,
            &bytes,
        )
    }

    /// Writes our own form.
    pub fn write_folder(&self, folder: &Folder) {
        folder.write("intrinsics.txt", self.intrinsics());
        let entries: Vec<String> = (0..12).map(|i| format!("world_from_camera_{}{}", i / 4, i % 4)).collect();
        let mut rows = format!("frame,{}\n", entries.join(","));
        for (i, pose) in self.poses.iter().enumerate() {
            folder.write(&format!("depth/{i:03}.png"), self.png(i));
            let matrix = rows_of(pose).map(|entry| entry.to_string());
            rows += &format!("{i},{}\n", matrix.join(","));
        }
        folder.write("poses.csv", rows);
    }

    /// Writes the form of TUM RGB-D, with a pose 5 ms after each image and another one half way to the next.
    pub fn write_tum(&self, folder: &Folder) {
        folder.write("intrinsics.txt", self.intrinsics() + "depth_unit_m 0.001\n");
        let mut images = "# depth maps\n# timestamp filename\n".to_owned();
        let mut poses = "# timestamp tx ty tz qx qy qz qw\n".to_owned();
        for (i, pose) in self.poses.iter().enumerate() {
            let time = 1305031102.0 + 0.1 * i as f64;
            folder.write(&format!("depth/{time:.4}.png"), self.png(i));
            images += &format!("{time:.4} depth/{time:.4}.png\n");
            let (t, q) = (pose.translation(), pose.rotation());
            poses +=
                &format!("{:.4} {} {} {} {} {} {} {}\n", time + 0.005, t.x, t.y, t.z, q.x, q.y, q.z, q.w);
            poses += &format!("{:.4} 0 0 0 0 0 0 1\n", time + 0.05);
        }
        folder.write("depth.txt", images);
        folder.write("groundtruth.txt", poses);
    }
}

/// The first three rows of a pose's matrix.
pub fn rows_of(pose: &Pose) -> [f64; 12] {
    let (m, t): (DMat3, _) = (pose.rotation_matrix(), pose.translation());
    [
        m.x_axis.x, m.y_axis.x, m.z_axis.x, t.x, m.x_axis.y, m.y_axis.y, m.z_axis.y, t.y, m.x_axis.z,
        m.y_axis.z, m.z_axis.z, t.z,
    ]
}

pub fn png(width: u32, height: u32, color: png::ColorType, depth: png::BitDepth, bytes: &[u8]) -> Vec<u8> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, width, height);
    encoder.set_color(color);
    encoder.set_depth(depth);
    encoder.write_header().unwrap().write_image_data(bytes).unwrap();
    file
}

fn millimetres(image: &DepthImage) -> Vec<u16> {
    let pixels = (0..image.height()).flat_map(|v| (0..image.width()).map(move |u| (u, v)));
    let of_pixel = |(u, v)| match image.get(u, v) {
        Depth::Surface(depth) => (1e3 * depth).round() as u16,
        _ => 0,
    };
    pixels.map(of_pixel).collect()
}
