//! A simulated robot: it moves to the requested pose, and its camera is noisy.

use crate::client::{Answer, Client};
use nextview::geometry::Pose;
use nextview::sensor::{Depth, DepthImage, Frame, Intrinsics};
use nextview::session::NextView;
use nextview_scan::{
    FrameSource, LiveConfig, NoiseConfig, NoiseModel, ScanConfig, SimulatedObject, Simulation, SourceConfig,
    TableRule, pose_of_rows,
};
use serde_json::{Value, json};
use std::path::PathBuf;

pub struct Robot {
    config: ScanConfig,
    object: SimulatedObject,
}

impl Robot {
    /// A robot that scans a mug in this number of views with a camera of this number of columns.
    pub fn new(n_views: usize, width: u32) -> Self {
        Self::with_noise(n_views, width, NoiseModel::D435i)
    }

    /// A robot whose camera makes no errors.
    pub fn exact(n_views: usize, width: u32) -> Self {
        Self::with_noise(n_views, width, NoiseModel::None)
    }

    /// A robot whose mug stands on a table.
    pub fn on_table(n_views: usize, width: u32) -> Self {
        let mut config = Self::exact(n_views, width).config;
        config.object_box.table = TableRule::Known;
        let object = SimulatedObject::new(&config).unwrap();
        Self { config, object }
    }

    /// A robot whose mug is turned as the results in a folder request.
    pub fn turned(&self, results: PathBuf) -> Self {
        let config = self.config.clone().going_on_after(results);
        let object = SimulatedObject::new(&config).unwrap();
        Self { config, object }
    }

    fn with_noise(n_views: usize, width: u32, model: NoiseModel) -> Self {
        let height = width * 3 / 4;
        let focal = glam::DVec2::splat(0.94 * width as f64);
        let center = glam::DVec2::new(0.5 * width as f64 - 0.5, 0.5 * height as f64 - 0.5);
        let config = ScanConfig {
            object: "builtin:mug".to_owned(),
            candidates: 60,
            views: Some(n_views),
            voxel_size_m: Some(0.006),
            baselines: false,
            camera: Intrinsics::pinhole(width, height, focal, center).unwrap(),
            noise: NoiseConfig { model, ..NoiseConfig::default() },
            ..ScanConfig::default()
        };
        let object = SimulatedObject::new(&config).unwrap();
        Self { config, object }
    }

    /// The scan that the program does by itself.
    pub fn simulated(&self) -> (&ScanConfig, Simulation<'_>) {
        (&self.config, Simulation::new(&self.object, &self.config, None))
    }

    /// The same scan with a user's camera, if the place of the object and the candidates are known.
    pub fn live(&self) -> ScanConfig {
        let bounds = self.object.scene.planning_box(self.object.voxel_size);
        let [min, max] = [bounds.min.to_array(), bounds.max.to_array()];
        let is_on_table = self.config.object_box.table == TableRule::Known;
        let live = LiveConfig {
            table_z_m: is_on_table.then(|| self.object.scene.room().min.z),
            box_m: Some([min[0], min[1], min[2], max[0], max[1], max[2]]),
            poses: self.object.views.poses().to_vec(),
            ..LiveConfig::default()
        };
        let noise = ScanConfig::default().noise;
        let object_box = ScanConfig::default().object_box;
        let source = SourceConfig::Live(live);
        ScanConfig { object: "mug".to_owned(), source, noise, object_box, ..self.config.clone() }
    }

    /// The body that creates that scan.
    pub fn body(&self, id: &str) -> Value {
        let mut body = serde_json::to_value(self.live()).unwrap();
        body["id"] = json!(id);
        body
    }

    /// What the camera takes from these rows of a pose.
    pub fn frame(&self, rows: &Value, is_first: bool) -> Frame {
        let pose = pose(rows);
        let next = NextView { view: None, world_from_camera: pose, choice: None, outlook: None };
        self.simulated().1.capture(&next, is_first).unwrap().frame
    }
}

pub fn pose(rows: &Value) -> Pose {
    let rows: [[f64; 4]; 4] = serde_json::from_value(rows.clone()).unwrap();
    pose_of_rows("world_from_camera", &rows).unwrap()
}

/// Path and body of a frame as 32-bit numbers, bit for bit.
pub fn raw(scan: &str, id: &str, rows: &Value, image: &DepthImage) -> (String, Vec<u8>) {
    let numbers: Vec<String> = rows
        .as_array()
        .unwrap()
        .iter()
        .flat_map(|row| row.as_array().unwrap())
        .map(Value::to_string)
        .collect();
    let (width, height) = (image.width(), image.height());
    let path = format!(
        "/scans/{scan}/frames?id={id}&width={width}&height={height}&dtype=f32&world_from_camera={}",
        numbers.join(",")
    );
    (path, metres(image).iter().flat_map(|depth| depth.to_le_bytes()).collect())
}

pub fn metres(image: &DepthImage) -> Vec<f32> {
    let pixels = (0..image.height()).flat_map(|v| (0..image.width()).map(move |u| image.get(u, v)));
    let metres = pixels.map(|pixel| match pixel {
        Depth::Missing => f32::NAN,
        Depth::Beyond => f32::INFINITY,
        Depth::Surface(depth) => depth,
    });
    metres.collect()
}

/// A PNG of 16-bit millimetres.
pub fn png(image: &DepthImage) -> Vec<u8> {
    let units =
        metres(image).into_iter().map(|depth| if depth.is_finite() { (1e3 * depth) as u16 } else { 0 });
    let bytes: Vec<u8> = units.flat_map(u16::to_be_bytes).collect();
    encoded(image.width(), image.height(), (png::ColorType::Grayscale, png::BitDepth::Sixteen), &bytes)
}

pub fn encoded(width: u32, height: u32, kind: (png::ColorType, png::BitDepth), bytes: &[u8]) -> Vec<u8> {
    let mut out = Vec::new();
    let mut encoder = png::Encoder::new(&mut out, width, height);
    encoder.set_color(kind.0);
    encoder.set_depth(kind.1);
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(bytes).unwrap();
    writer.finish().unwrap();
    out
}

/// A multipart body, with its content type.
pub fn multipart(parts: &[(&str, &[u8])]) -> (String, Vec<u8>) {
    let mut body = Vec::new();
    for (name, bytes) in parts {
        body.extend(
            format!("--frontier\r\ncontent-disposition: form-data; name=\"{name}\"\r\n\r\n").into_bytes(),
        );
        body.extend_from_slice(bytes);
        body.extend(b"\r\n");
    }
    body.extend(b"--frontier--\r\n");
    ("multipart/form-data; boundary=frontier".to_owned(), body)
}

/// Posts a frame as raw numbers.
pub fn post_raw(client: &mut Client, scan: &str, id: &str, rows: &Value, image: &DepthImage) -> Answer {
    let (path, body) = raw(scan, id, rows, image);
    client.send("POST", &path, "application/octet-stream", &body).unwrap()
}
