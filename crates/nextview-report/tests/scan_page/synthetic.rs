//! A synthetic scan: a vase with a ring on it, seen from ten places.

use glam::{DMat3, DQuat, DVec2, DVec3, IVec3, Vec3};
use nextview::geometry::{Pose, sphere::fibonacci_hemisphere};
use nextview::sensor::{DepthImage, Intrinsics};
use nextview::session::StopReason;
use nextview_report::{ScanPage, ShownModel, ViewPicture, scan_page};
use nextview_scan::{PlannerName, Profile, QualityMm, ScanConfig, ScanRecord, StepRecord};
use std::collections::HashSet;

const N_CANDIDATES: usize = 64;
const CENTER: DVec3 = DVec3::new(0.0, 0.0, 0.09);

/// All that the page shows.
pub struct SyntheticRecording {
    pub record: ScanRecord,
    pub config: ScanConfig,
    pub depths: Vec<DepthImage>,
    pub points: Vec<Vec<Vec3>>,
    pub paths: Vec<Vec<DVec3>>,
    pub candidates: Vec<DVec3>,
    pub command: String,
    pub config_text: String,
}

impl SyntheticRecording {
    /// The page, with as many pictures as there are depth images.
    pub fn page(&self) -> String {
        let parts = self.depths.iter().zip(&self.points).zip(&self.paths);
        let picture = |((depth, points), path): ((&DepthImage, &Vec<Vec3>), &Vec<DVec3>)| ViewPicture {
            depth: depth.clone(),
            color: None,
            points: points.clone(),
            path: path.clone(),
        };
        scan_page(&ScanPage {
            record: &self.record,
            config: &self.config,
            views: &parts.map(picture).collect::<Vec<_>>(),
            candidates: &self.candidates,
            model: &ShownModel::default(),
            next: None,
            command: &self.command,
            config_text: &self.config_text,
        })
    }
}

/// A scan of `n_views` views of `width` x `width * 3 / 4` pixels.
pub fn scan(n_views: usize, width: u32) -> SyntheticRecording {
    let candidates: Vec<DVec3> =
        (0..N_CANDIDATES).map(|i| CENTER + 0.42 * fibonacci_hemisphere(i, N_CANDIDATES)).collect();
    let camera = camera(width);
    let config = ScanConfig { camera, views: Some(n_views), ..ScanConfig::of_profile(Profile::Default) };
    let record = ScanRecord {
        object: "vase_with_ring".into(),
        planner: PlannerName::MostSurface.into(),
        profile: Profile::Default,
        seed: 42,
        stop_reason: Some(StopReason::ViewLimit),
        candidates: N_CANDIDATES,
        views: n_views,
        skill: Some(0.81),
        peak_memory_mb: Some(79.0),
        ..ScanRecord::default()
    };
    let mut made = SyntheticRecording {
        record,
        config,
        depths: Vec::new(),
        points: Vec::new(),
        paths: Vec::new(),
        candidates,
        command: "nextview scan vase_with_ring.obj --planner most-surface --views 10 --seed 42".into(),
        config_text: "voxel_size_m = 0.004\nseed = 42\n\n[sensor_model]\nhit = 0.7\nmiss = 0.4".into(),
    };
    let mut seen = HashSet::new();
    for i in 0..n_views {
        take(&mut made, (20 + 23 * i) % N_CANDIDATES, &mut seen);
    }
    measure(&mut made.record, 1.04 * seen.len() as f64);
    made
}

/// Fills in the measures: coverage out of `total` voxels, and baselines.
fn measure(record: &mut ScanRecord, total: f64) {
    let mut n_seen = 0;
    for step in &mut record.steps {
        n_seen += step.new_voxels;
        let coverage = n_seen as f64 / total;
        step.reachable_coverage = Some(coverage);
        step.voxel_coverage = Some(0.99 * coverage);
        step.false_voxels = Some(12);
        step.map_precision = Some(0.991);
        step.map_recall = Some(0.985 * coverage);
        step.map_iou = Some(0.98 * coverage);
        step.surface_coverage_2mm = Some(0.98 * coverage);
        step.surface_coverage_5mm = Some(coverage);
    }
    let n_views = record.views;
    let curve =
        |rate: f64, limit: f64| (1..=n_views).map(|i| limit * (1.0 - (-rate * i as f64).exp())).collect();
    record.random_curve = Some(curve(0.38, 0.94));
    record.random_low_curve = Some(curve(0.26, 0.9));
    record.random_high_curve = Some(curve(0.52, 0.97));
    record.clairvoyant_curve = Some(curve(0.75, 0.985));
    record.coverage_auc_views = Some(0.774);
    record.coverage_auc_time = Some(0.702);
    record.coverage_auc_horizon_s = Some(60.0);
    record.reachable_coverage = record.steps.last().and_then(|step| step.reachable_coverage);
    record.set_cloud(Some(QualityMm {
        accuracy_mean_mm: 0.41,
        accuracy_median_mm: 0.3,
        accuracy_p95_mm: 1.2,
        completeness_1mm: 0.881,
        completeness_2mm: 0.946,
        completeness_5mm: 0.97,
        completeness_mean_mm: 0.5,
        f_score_1mm: Some(0.902),
        f_score_2mm: Some(0.961),
        f_score_5mm: Some(0.984),
        chamfer_mm: Some(0.43),
        ..QualityMm::default()
    }));
}

fn camera(width: u32) -> Intrinsics {
    let (w, h) = (width as f64, (width * 3 / 4) as f64);
    Intrinsics::pinhole(width, width * 3 / 4, DVec2::splat(0.95 * w), DVec2::new(w, h) / 2.0 - 0.5).unwrap()
}

fn look_at_center(eye: DVec3) -> Pose {
    let z = (CENTER - eye).normalize();
    let x = z.cross(DVec3::Z).normalize();
    Pose::new(DQuat::from_mat3(&DMat3::from_cols(x, z.cross(x), z)), eye).unwrap()
}

/// Takes this view.
fn take(made: &mut SyntheticRecording, view: usize, seen: &mut HashSet<IVec3>) {
    let pose = look_at_center(made.candidates[view]);
    let camera = made.config.camera;
    let mut depth = Vec::new();
    let mut points: Vec<Vec3> = Vec::new();
    let mut new_voxels = HashSet::new();
    for v in 0..camera.height() {
        for u in 0..camera.width() {
            let ray = camera.deproject(DVec2::new(u as f64, v as f64)).unwrap().extend(1.0);
            let d = ray_depth(pose, ray);
            depth.push(d as f32);
            let point = pose.transform_point(d * ray);
            let voxel = (point / 0.004).floor().as_ivec3();
            if d.is_finite() && !seen.contains(&voxel) {
                points.push(point.as_vec3());
                new_voxels.insert(voxel);
            }
        }
    }
    let before = made.record.steps.last();
    let path = before.map_or(vec![], |before| arc(before.position_m.into(), pose.translation()));
    let travel: f64 = path.windows(2).map(|w| w[0].distance(w[1])).sum();
    let n_new = new_voxels.len();
    made.record.steps.push(StepRecord {
        step: made.record.steps.len() + 1,
        view: Some(view),
        position_m: pose.translation().to_array(),
        quaternion_xyzw: pose.rotation().to_array(),
        runner_up: before.map(|_| view + 1),
        expected_new_voxels: before.map(|_| 1.1 * n_new as f64),
        estimated_completeness: before.map(|_| 0.75),
        hit_voxels: 1000,
        new_voxels: n_new,
        plan_time_ms: if before.is_none() { 0.0 } else { 30.0 + 0.7 * (view % 17) as f64 },
        map_time_ms: 20.0,
        path_length_m: before.map_or(0.0, |before| before.path_length_m) + travel,
        ..StepRecord::default()
    });
    seen.extend(new_voxels);
    made.depths.push(DepthImage::from_metres(camera.width(), camera.height(), depth).unwrap());
    made.points.push(points);
    made.paths.push(path);
}

/// Depth by sphere tracing; missing where the surface is seen at a flat angle or is black (a belt around the
/// vase), infinite where there is none.
fn ray_depth(pose: Pose, ray: DVec3) -> f64 {
    let direction = pose.rotation() * ray;
    let mut t = 0.1;
    while t < 0.9 {
        let point = pose.translation() + t * direction;
        let d = distance(point);
        if d < 1e-5 {
            let gradient = |axis: DVec3| distance(point + 1e-4 * axis) - distance(point - 1e-4 * axis);
            let normal = DVec3::new(gradient(DVec3::X), gradient(DVec3::Y), gradient(DVec3::Z)).normalize();
            let black = (0.06..0.068).contains(&point.z);
            return if normal.dot(direction.normalize()) < -0.12 && !black { t } else { f64::NAN };
        }
        t += 0.7 * d / direction.length();
    }
    f64::INFINITY
}

/// Distance to the synthetic object: a wavy tube, closed at the bottom, and a leaning ring.
fn distance(p: DVec3) -> f64 {
    let across = p.truncate().length();
    let radius = 0.05 + 0.014 * (p.z * 38.0).sin();
    let wall = ((across - radius).abs() - 0.004).max(p.z - 0.18).max(-p.z);
    let floor = (across - radius).max((p.z - 0.004).abs() - 0.004);
    let q = DQuat::from_rotation_x(0.5) * (p - DVec3::new(0.055, 0.0, 0.1));
    let ring = DVec2::new(DVec2::new(q.x, q.z).length() - 0.045, q.y).length() - 0.009;
    wall.min(floor).min(ring)
}

fn arc(a: DVec3, b: DVec3) -> Vec<DVec3> {
    let (a, b) = (a - CENTER, b - CENTER);
    let point = |i: usize| {
        let t = i as f64 / 12.0;
        CENTER + 0.42 * (a * (1.0 - t) + b * t).normalize()
    };
    (0..=12).map(point).collect()
}
