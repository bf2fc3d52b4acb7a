//! A planner of your own: it goes to the view that is farthest from all views so far, and says how far that
//! is.

use nextview::Error;
use nextview::geometry::{Aabb, Pose};
use nextview::glam::{DVec2, DVec3};
use nextview::object::planning_box;
use nextview::planner::{Choice, Plan, Situation, ViewPlanner};
use nextview::sensor::{DepthImage, Frame, Intrinsics};
use nextview::session::{Decision, Session, SessionConfig, StopReason};
use nextview::view::generate;

const RADIUS: f64 = 0.08;
const VOXEL_SIZE: f64 = 0.01;

/// Takes the view farthest from those taken, as long as that is more than a stated distance, metres.
struct FarthestView {
    least_distance: f64,
}

impl ViewPlanner for FarthestView {
    fn plan(&mut self, situation: &Situation<'_>) -> Result<Plan, Error> {
        let position = |view: usize| situation.views().pose(view).translation();
        let mut best: Option<Choice> = None;
        for view in situation.open_views() {
            situation.cancel().check()?;
            let distances = situation.visited().iter().map(|&other| position(view).distance(position(other)));
            let nearest = distances.fold(f64::INFINITY, f64::min);
            // Of views as far away, the lowest number wins.
            if nearest > best.as_ref().map_or(self.least_distance, |best| best.score) {
                let runner_up = best.map(|best| best.view);
                let explanation = Some([("nearest_view_m", nearest)].into());
                best = Some(Choice { view, score: nearest, runner_up, explanation });
            }
        }
        Ok(Plan { choice: best, ..Plan::default() })
    }
}

fn main() -> Result<(), Error> {
    let camera = Intrinsics::pinhole(160, 120, DVec2::splat(150.0), DVec2::new(79.5, 59.5))?;
    let bounds = planning_box(&Aabb::cube(DVec3::ZERO, RADIUS), VOXEL_SIZE);
    let config = SessionConfig { max_views: 100, ..SessionConfig::new(VOXEL_SIZE, bounds) };
    let views = generate::fibonacci_sphere(DVec3::ZERO, 0.35, 200)?;
    let planner = FarthestView { least_distance: 0.3 };
    let mut session = Session::new(config, camera, views, Box::new(planner))?;

    let mut distances = Vec::new();
    let reason = loop {
        match session.decide()? {
            Decision::Move(next) => {
                let explanation = next.choice.and_then(|choice| choice.explanation);
                distances.extend(explanation.and_then(|explanation| explanation.get("nearest_view_m")));
                session.observe(&capture(&camera, &next.world_from_camera)?)?;
            }
            Decision::Stop(reason) => break reason,
        }
    };

    println!("{reason:?} after {} views, {distances:.2?} m from those before", session.visited().len());
    assert_eq!(reason, StopReason::NothingToGain);
    assert!(distances.len() > 5 && distances.is_sorted_by(|a, b| a >= b));
    Ok(())
}

/// What a depth camera sees of a ball of 8 cm at the origin: the nearer solution of a quadratic equation for
/// every pixel.
fn capture(camera: &Intrinsics, world_from_camera: &Pose) -> Result<Frame, Error> {
    let position = world_from_camera.translation();
    let depth = |pixel: u32| {
        let pixel = DVec2::new((pixel % camera.width()) as f64, (pixel / camera.width()) as f64);
        let Some(ideal) = camera.deproject(pixel) else { return f32::NAN };
        let ray = world_from_camera.rotation() * ideal.extend(1.0);
        let (a, b) = (ray.length_squared(), ray.dot(position));
        let root = b * b - a * (position.length_squared() - RADIUS * RADIUS);
        if root > 0.0 { ((-b - root.sqrt()) / a) as f32 } else { f32::INFINITY }
    };
    let depth = (0..camera.n_pixels() as u32).map(depth).collect();
    let image = DepthImage::from_metres(camera.width(), camera.height(), depth)?;
    Frame::new(image, *camera, *world_from_camera, 2.0)
}
