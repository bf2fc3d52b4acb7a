//! A scan that never happened: a vase with a ring on it, seen from ten places.

use glam::{DMat3, DQuat, DVec2, DVec3, IVec3, Vec3};
use nextview::geometry::{Pose, sphere::fibonacci_hemisphere};
use nextview::planner::{Choice, Outlook};
use nextview::sensor::{DepthImage, Intrinsics};
use nextview_cli::report::{RandomCurve, ScanReport, Step};
use std::collections::HashSet;

const N_CANDIDATES: usize = 64;
const CENTER: DVec3 = DVec3::new(0.0, 0.0, 0.09);

/// A report with `n_views` views of `width` x `width * 3 / 4` pixels.
pub fn report(n_views: usize, width: u32) -> ScanReport {
    let camera = camera(width);
    let candidates: Vec<DVec3> =
        (0..N_CANDIDATES).map(|i| CENTER + 0.42 * fibonacci_hemisphere(i, N_CANDIDATES)).collect();
    let mut seen = HashSet::new();
    let mut steps: Vec<Step> = Vec::new();
    for i in 0..n_views {
        let view = (20 + 23 * i) % N_CANDIDATES;
        let step = step(view, look_at_center(candidates[view]), &camera, &mut seen, steps.last());
        steps.push(step);
    }
    let total = 1.04 * seen.len() as f64;
    let mut n_seen = 0;
    for step in &mut steps {
        n_seen += step.new_voxels;
        step.coverage = Some(n_seen as f64 / total);
    }
    let curve =
        |rate: f64, limit: f64| (1..=n_views).map(|i| limit * (1.0 - (-rate * i as f64).exp())).collect();
    ScanReport {
        object: "vase_with_ring.obj".into(),
        planner: "maximum coverage".into(),
        profile: "balanced".into(),
        seed: 42,
        stop_reason: format!("budget of {n_views} views used up"),
        summary: summary(),
        steps,
        random: Some(RandomCurve {
            mean: curve(0.38, 0.94),
            low: curve(0.26, 0.9),
            high: curve(0.52, 0.97),
            band: "5th to 95th percentile of 100 scans".into(),
        }),
        clairvoyant: Some(curve(0.75, 0.985)),
        candidates,
        camera,
        command: "nextview scan vase_with_ring.obj --planner coverage --views 10 --seed 42".into(),
        config: "voxel_size_m = 0.004\nseed = 42\n\n[sensor_model]\nhit = 0.7\nmiss = 0.4\n\n[camera]\nwidth = 640\nheight = 480".into(),
    }
}

fn summary() -> Vec<(String, String)> {
    let rows = [
        ("Voxel coverage", "95.8 %"),
        ("Surface coverage at 1 mm", "88.1 %"),
        ("Surface coverage at 2 mm", "94.6 %"),
        ("Surface coverage at 5 mm", "97.0 %"),
        ("False voxels", "12"),
        ("Skill (0 random, 1 clairvoyant)", "0.81"),
        ("Total time", "1.92 s"),
    ];
    rows.map(|(label, value)| (label.to_owned(), value.to_owned())).to_vec()
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

fn step(
    view: usize,
    pose: Pose,
    camera: &Intrinsics,
    seen: &mut HashSet<IVec3>,
    before: Option<&Step>,
) -> Step {
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
    let n_new = new_voxels.len();
    seen.extend(new_voxels);
    let path = before.map_or(vec![], |b| arc(b.world_from_camera.translation(), pose.translation()));
    Step {
        view: Some(view),
        world_from_camera: pose,
        depth: DepthImage::from_metres(camera.width(), camera.height(), depth).unwrap(),
        points,
        coverage: None,
        new_voxels: n_new,
        choice: before.map(|_| Choice {
            view,
            score: 0.01,
            local_share: 0.01,
            flow_share: 0.0,
            runner_up: Some(view + 1),
        }),
        outlook: before.map(|_| Outlook { n_seen: 3000, n_expected: 1.1 * n_new as f64, n_unseen: 1000.0 }),
        plan_time: if before.is_none() { 0.0 } else { 0.03 + 0.0007 * (view % 17) as f64 },
        travel: path.windows(2).map(|w| w[0].distance(w[1])).sum(),
        path,
    }
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

/// Distance to the made-up object: a wavy tube, closed at the bottom, and a leaning ring.
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
