use crate::housing::housing;
use crate::optimizer::VoxelSample;
use glam::{DQuat, DVec2, DVec3};
use nextview::Cancel;
use nextview::gain::ExpectedSurface;
use nextview::geometry::random::Random;
use nextview::geometry::{Aabb, Lattice, Pose, SegmentWalk};
use nextview::map::{Occupancy, Snapshot};
use nextview::object::Table;
use nextview::planner::{MostSurface, MostSurfaceConfig, RandomViews, ViewPlanner};
use nextview::prior::{SurfacePrior, VoxelFeatures};
use nextview::sensor::{DepthRange, Frame, Intrinsics};
use nextview::session::{Decision, Session, SessionConfig};
use nextview::view::{ViewSpace, generate};
use nextview::visibility::MeasuredParts;
use nextview_sim::mesh::TriangleMesh;
use nextview_sim::noise::{Noise, PoseError, SensorNoise};
use nextview_sim::random_object::random_object;
use nextview_sim::scene::Scene;
use nextview_sim::truth::ObjectVoxels;
use std::sync::Arc;

/// Longest side of all objects, metres; for the features, only voxels have a size.
const SIZE: f64 = 0.2;

/// Voxel sizes of scans, metres: 26 to 66 voxels along the box.
const VOXEL_SIZES: [f64; 4] = [0.01, 0.007, 0.005, 0.0036];

/// Share of scans over a table.
const WITH_TABLE: f64 = 0.35;

/// Share of scans with the noise of a D435i and wrong poses.
const WITH_NOISE: f64 = 0.4;

/// Share of scans with a box larger than the object needs, and the maximum factor.
const WITH_ROOM: f64 = 0.3;
const MOST_ROOM: f64 = 1.5;

/// Pixels between the first network's training rays, and number of views they are cast from.
const PIXELS_APART: usize = 8;
const N_LOOKS: usize = 8;

/// Numbers of views of a scan, and of candidates.
const N_VIEWS: usize = 7;
const N_CANDIDATES: usize = 150;

/// An object to scan, with all random choices of the scan.
#[derive(Clone, Debug)]
pub struct Source {
    /// A mesh to rotate and stretch, or else a random object, of which every fourth is a housing.
    pub mesh: Option<Arc<TriangleMesh>>,
    /// Seed of the random choices.
    pub seed: u64,
}

/// The quantity that a network learns from a scan.
#[derive(Clone, Copy, Debug)]
pub enum Target<'a> {
    /// Whether a ray that reaches an unknown voxel ends at the surface in it.
    Stops,
    /// Whether a view shows something new of a voxel, given its visibility under this prior, with which half
    /// of the scans are planned.
    Shows(&'a SurfacePrior),
}

impl Source {
    /// Returns samples from a scan, up to `n_per_view` after each view.
    pub fn samples(&self, target: Target<'_>, n_per_view: usize) -> Vec<VoxelSample> {
        let mut random = Random::new(self.seed, 21);
        let scan = TrainingScan::new(self, &mut random);
        let planner: Box<dyn ViewPlanner> = match target {
            Target::Shows(prior) if random.unit() < 0.5 => {
                let planner = MostSurface::with_prior(MostSurfaceConfig::default(), prior.clone());
                Box::new(planner.expect("the defaults are in range"))
            }
            _ => Box::new(RandomViews { seed: self.seed }),
        };
        let mut session = scan.session(planner, &mut random);
        let mut samples = Vec::new();
        while let Decision::Move(next) = session.decide().expect("the planner cannot fail") {
            let frame = scan.scene.camera().capture(&next.world_from_camera);
            let frame = frame.expect("candidates are in the room");
            session.observe(&frame).expect("nobody cancels");
            let Some(snapshot) = session.snapshot() else { continue };
            let all = match target {
                Target::Stops => scan.rays(&snapshot, &mut random),
                Target::Shows(prior) => scan.observations(&snapshot, session.frames(), prior, &mut random),
            };
            let features = features(&snapshot);
            let n_samples = if all.is_empty() { 0 } else { n_per_view };
            samples.extend((0..n_samples).map(|_| {
                let Observation { item, output, is_so } = all[random.index(all.len())];
                VoxelSample { row: features.rows[item as usize], output, is_so }
            }));
        }
        samples
    }

    fn object(&self, random: &mut Random) -> TriangleMesh {
        let object = match &self.mesh {
            None if self.seed % 4 == 3 => varied(&housing(self.seed), random),
            None => random_object(self.seed),
            Some(mesh) => varied(mesh, random),
        };
        let size = object.bounds().longest_side();
        object.scaled(SIZE / size).expect("a mesh of any size can be scaled to this one")
    }
}

fn features(snapshot: &Snapshot) -> VoxelFeatures {
    VoxelFeatures::new(snapshot, &Cancel::default()).expect("nobody cancels")
}

/// The mesh rotated, stretched and rotated again; in half of all cases about the vertical axis only.
fn varied(mesh: &TriangleMesh, random: &mut Random) -> TriangleMesh {
    let first = DQuat::from_rotation_z(random.range(0.0, std::f64::consts::TAU));
    let stretch = DVec3::new(random.range(0.6, 1.0), random.range(0.6, 1.0), random.range(0.6, 1.0));
    let second = if random.unit() < 0.5 {
        DQuat::from_rotation_z(random.range(0.0, std::f64::consts::TAU))
    } else {
        DQuat::from_rotation_arc(DVec3::Z, (random.in_cube() + 1e-9).normalize())
    };
    let vertices = mesh.vertices().iter().map(|&vertex| second * (stretch * (first * vertex))).collect();
    TriangleMesh::new(vertices, mesh.triangles().to_vec()).expect("a mesh stays one when it is stretched")
}

/// An object in front of a camera.
struct TrainingScan {
    scene: Scene,
    views: ViewSpace,
    voxel_size: f64,
    has_table: bool,
    /// The planning box of the scan.
    bounds: Aabb,
    object: ObjectVoxels,
}

/// An observation that may hold for a voxel.
#[derive(Clone, Copy)]
struct Observation {
    /// Its index among the voxels with features.
    item: u32,
    output: u8,
    is_so: bool,
}

impl TrainingScan {
    fn new(source: &Source, random: &mut Random) -> Self {
        let voxel_size = VOXEL_SIZES[random.index(VOXEL_SIZES.len())];
        let has_table = random.unit() < WITH_TABLE;
        let object = source.object(random);
        let scene = Scene::new(object, Intrinsics::d435i()).expect("the objects are small");
        let scene = if has_table { scene.with_table().expect("the camera stands above") } else { scene };
        let noise = Noise {
            seed: source.seed,
            depth: Some(SensorNoise::d435i()),
            pose: PoseError { translation_sigma: 0.002, rotation_sigma: 0.2_f64.to_radians() },
            first_pose_is_right: true,
        };
        let noise = if random.unit() < WITH_NOISE { noise } else { Noise::default() };
        let scene = scene.with_noise(noise).expect("errors in range");
        let n_around = if has_table { 2 * N_CANDIDATES } else { N_CANDIDATES };
        let around = generate::shell(scene.center(), scene.size(), n_around, source.seed).expect("a shell");
        let lowest = scene.room().min.z + 0.03;
        let poses = around.poses().iter().filter(|pose| !has_table || pose.translation().z > lowest);
        let views = ViewSpace::new(poses.copied().collect()).expect("some are above the table");
        let lattice = Lattice::new(voxel_size).expect("a length");
        let close = scene.planning_box(voxel_size);
        let room = if random.unit() < WITH_ROOM { random.range(1.0, MOST_ROOM) } else { 1.0 };
        let bounds = Aabb::cube(close.center(), 0.5 * room * close.longest_side());
        let block = lattice.block_inside(&close).expect("larger than a voxel");
        let object = ObjectVoxels::new(scene.camera().mesh(), lattice, block);
        Self { scene, views, voxel_size, has_table, bounds, object }
    }

    fn session(&self, planner: Box<dyn ViewPlanner>, random: &mut Random) -> Session {
        let table = if self.has_table { Table::AtHeight(self.scene.room().min.z) } else { Table::None };
        let config = SessionConfig {
            table,
            first_view: random.index(self.views.len()),
            max_views: N_VIEWS,
            ..SessionConfig::new(self.voxel_size, self.bounds)
        };
        let camera = *self.scene.camera().intrinsics();
        Session::new(config, camera, self.views.clone(), planner).expect("all is in range")
    }

    fn random_view(&self, random: &mut Random) -> Pose {
        self.views.pose(random.index(self.views.len()))
    }

    /// The unknown voxels that the rays of a few views reach, up to the one in which they meet surface.
    fn rays(&self, snapshot: &Snapshot, random: &mut Random) -> Vec<Observation> {
        let (features, lattice, block) = (features(snapshot), snapshot.lattice(), snapshot.block());
        let mut item_of = vec![u32::MAX; block.n_voxels()];
        features.voxels.iter().zip(0..).for_each(|(&voxel, item)| item_of[voxel as usize] = item);
        let mut all = Vec::new();
        for _ in 0..N_LOOKS {
            let pose = self.random_view(random);
            for end in self.ray_ends(&pose) {
                let (from, to) = (lattice.to_voxels(pose.translation()), lattice.to_voxels(end));
                let mut walk = SegmentWalk::within(from, to, block.min(), block.max());
                while let Some(at) = &mut walk {
                    let voxel = block.index(at.key()).expect("the walk is within the block");
                    if snapshot.occupancy()[voxel] == Occupancy::Unknown {
                        let is_so = at.key() == lattice.key(end);
                        all.push(Observation { item: item_of[voxel], output: 0, is_so });
                    }
                    if at.advance().is_none() {
                        break;
                    }
                }
            }
        }
        all
    }

    /// The true ends of a view's rays, in world coordinates.
    fn ray_ends(&self, pose: &Pose) -> Vec<DVec3> {
        let camera = self.scene.camera();
        let depths = camera.render_depth(pose).expect("candidates are in the room");
        let (width, optics) = (camera.intrinsics().width() as usize, camera.intrinsics());
        let mut ends = Vec::new();
        for (v, row) in depths.chunks_exact(width).enumerate().step_by(PIXELS_APART) {
            for (u, &depth) in row.iter().enumerate().step_by(PIXELS_APART) {
                let ideal = optics.deproject(DVec2::new(u as f64, v as f64));
                let Some(ideal) = ideal.filter(|_| depth.is_finite()) else { continue };
                ends.push(pose.transform_point(ideal.extend(1.0) * f64::from(depth)));
            }
        }
        ends
    }

    /// The observations by a few views of the voxels on their rays.
    fn observations(
        &self,
        snapshot: &Snapshot,
        frames: &[Frame],
        prior: &SurfacePrior,
        random: &mut Random,
    ) -> Vec<Observation> {
        let estimate = prior.estimate(snapshot, &Cancel::default()).expect("nobody cancels");
        let camera = self.scene.camera();
        let optics = camera.intrinsics();
        let measured = MeasuredParts::new(frames, snapshot, &Cancel::default()).expect("nobody cancels");
        let gain = ExpectedSurface::new(snapshot, optics, DepthRange::default(), &measured, &estimate, 1.0);
        let gain = gain.expect("the spacing is positive");
        let (mut evaluator, mut all) = (gain.evaluator(), Vec::new());
        for _ in 0..4 {
            let pose = self.random_view(random);
            let seen = self.object.seen_from(camera, &pose).expect("candidates are in the room");
            evaluator.survey(&pose, |item, class| {
                let key = snapshot.block().key(estimate.voxels()[item] as usize);
                let is_so = self.object.number(key).is_some_and(|number| seen[number]);
                all.push(Observation { item: item as u32, output: class.index() as u8, is_so });
            });
        }
        all
    }
}
