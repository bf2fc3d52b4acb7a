//! A gain of your own, in the greedy planner: views are rated by the number of unknown voxels that their rays
//! reach first.

use nextview::gain::InformationGain;
use nextview::geometry::{Aabb, Pose};
use nextview::glam::{DVec2, DVec3};
use nextview::map::{Occupancy, Snapshot};
use nextview::object::planning_box;
use nextview::planner::{Greedy, GreedyConfig};
use nextview::sensor::{DepthImage, Frame, Intrinsics};
use nextview::session::{Decision, Session, SessionConfig};
use nextview::view::generate;
use nextview::visibility::{FreeSpace, Ray, Sight};
use nextview::{Cancel, Cancelled, Error};
use std::collections::HashSet;

const RADIUS: f64 = 0.08;
const VOXEL_SIZE: f64 = 0.01;

/// The number of unknown voxels that are the first unknown ones on a ray of the view, each counted once.
struct FirstUnknown {
    is_unknown: Vec<bool>,
}

impl InformationGain for FirstUnknown {
    const SIGHT: Sight = Sight::endless(FreeSpace::Clear);

    type Tally = HashSet<u32>;

    fn new(snapshot: &Snapshot, _: &[Frame], _: &Cancel) -> Result<Self, Cancelled> {
        let is_unknown = snapshot.occupancy().iter().map(|state| *state == Occupancy::Unknown).collect();
        Ok(Self { is_unknown })
    }

    fn add(&self, ray: &Ray<'_>, reached: &mut HashSet<u32>) {
        let mut voxels = ray.crossings.iter().map(|crossing| crossing.voxel);
        reached.extend(voxels.find(|&voxel| self.is_unknown[voxel as usize]));
    }

    fn total(reached: &HashSet<u32>) -> f64 {
        reached.len() as f64
    }
}

fn main() -> Result<(), Error> {
    let camera = Intrinsics::pinhole(160, 120, DVec2::splat(150.0), DVec2::new(79.5, 59.5))?;
    let bounds = planning_box(&Aabb::cube(DVec3::ZERO, RADIUS), VOXEL_SIZE);
    let config = SessionConfig { max_views: 6, ..SessionConfig::new(VOXEL_SIZE, bounds) };
    let views = generate::fibonacci_sphere(DVec3::ZERO, 0.35, 200)?;
    let planner = Greedy::<FirstUnknown>::new(GreedyConfig::default())?;
    let mut session = Session::new(config, camera, views, Box::new(planner))?;

    let mut gains = Vec::new();
    while let Decision::Move(next) = session.decide()? {
        gains.extend(next.choice.map(|choice| choice.score));
        session.observe(&capture(&camera, &next.world_from_camera)?)?;
    }

    println!("shares of all gain: {gains:.4?}");
    let snapshot = session.snapshot().ok_or(Error::InvalidParameter {
        name: "object",
        value: "none".into(),
        expected: "a ball in front of the camera",
    })?;
    // The surface of the ball, in voxels of a centimetre.
    let n_surface = 4.0 * std::f64::consts::PI * (RADIUS / VOXEL_SIZE).powi(2);
    let n_occupied = snapshot.count(Occupancy::Occupied) as f64;
    println!("{n_occupied} voxels occupied, the surface is {n_surface:.0} voxels large");
    assert!(n_occupied > n_surface && gains.len() == 5);
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
