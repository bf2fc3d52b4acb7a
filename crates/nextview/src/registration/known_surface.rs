use super::camera::FrameCamera;
use super::fitting::{Fitting, PoseComparison};
use super::icp::{SearchReach, pairs};
use super::joint::{self, JointView};
use super::pair::Pair;
use super::point_tree::PointTree;
use super::pose_fit::PoseFit;
use super::pose_prior::PosePrior;
use super::surface_points::{SurfacePoint, surface_points};
use super::{GivenPoses, Registration, RegistrationConfig};
use crate::geometry::{Aabb, Lattice, Pose};
use crate::sensor::Frame;
use crate::{Cancel, Cancelled, Error};
use glam::{DVec3, IVec3};
use rustc_hash::FxHashMap;

/// The surface shown by the frames so far: the target for aligning a new frame.
///
/// Points are pooled in cells, separately for each side, so that the two sides of a thin wall stay two
/// surfaces. The state depends only on the frames and their order, not on the number of threads.
///
/// ```
/// use glam::{DQuat, DVec2, DVec3};
/// use nextview::Cancel;
/// use nextview::geometry::{Aabb, Pose};
/// use nextview::registration::{KnownSurface, RegistrationConfig};
/// use nextview::sensor::{DepthImage, Frame, Intrinsics};
///
/// // A pyramid whose tip is 0.4 m in front of the camera.
/// let camera = Intrinsics::pinhole(160, 120, DVec2::splat(150.0), DVec2::new(79.5, 59.5)).unwrap();
/// let ideal = |i: usize| camera.deproject(DVec2::new((i % 160) as f64, (i / 160) as f64)).unwrap();
/// let depth = (0..160 * 120).map(|i| (0.4 / (1.0 - ideal(i).abs().max_element())) as f32).collect();
/// let image = DepthImage::from_metres(160, 120, depth).unwrap();
/// let frame = Frame::new(image, camera, Pose::IDENTITY, 1.0).unwrap();
///
/// let bounds = Aabb::cube(DVec3::new(0.0, 0.0, 0.45), 0.1);
/// let mut known = KnownSurface::new(RegistrationConfig::default()).unwrap();
/// let never = &Cancel::default();
/// known.add(&frame, &frame.world_from_camera(), bounds, never).unwrap();
/// let wrong = Pose::new(DQuat::from_rotation_z(0.02), DVec3::new(0.01, 0.0, -0.005)).unwrap();
/// let found = known.register(&frame.with_pose(wrong), bounds, never).unwrap();
/// assert!(found.is_accepted() && found.world_from_camera.translation().length() < 1e-3);
/// ```
#[derive(Clone, Debug)]
pub struct KnownSurface {
    config: RegistrationConfig,
    /// Edge of the cells, metres.
    spacing: f64,
    lattice: Lattice,
    slots: FxHashMap<(IVec3, u8), usize>,
    /// The pools, in the order in which their cells were first met.
    pools: Vec<CellPool>,
    tree: PointTree,
    /// The views of the frames, in the order in which they were added.
    views: Vec<KnownView>,
    prior: PosePrior,
}

/// A frame that was added.
#[derive(Clone, Debug)]
struct KnownView {
    joint: JointView,
    camera: FrameCamera,
    /// The points that are pooled, in the camera frame.
    points: Vec<SurfacePoint>,
    /// Edge of the cells of the view's own points, metres.
    fine_spacing: f64,
    /// The pose when frames were last far from where they had been.
    far_pose: Pose,
}

/// Sums over the points of a cell.
#[derive(Clone, Copy, Debug, Default)]
struct CellPool {
    n: f64,
    position: DVec3,
    normal: DVec3,
}

/// Poses of all frames after they were aligned to each other.
#[derive(Clone, Debug)]
pub struct Realigned {
    /// By frame, in the order in which they were added.
    pub poses: Vec<Pose>,
    /// Whether they moved points of an earlier frame by more than a tenth of a cell (root mean square) from
    /// where they were when this was last so, or when the frame was added: by more than a map notices.
    pub is_far: bool,
    /// How well they fit together.
    pub fit: PoseFit,
}

/// Final search distance for correspondences, in cells: twice the distance between neighbouring known points.
const REACH_IN_CELLS: f64 = 2.0;

/// Final search distance when all frames are aligned to each other, in cells of the points that this uses.
const REACH_IN_FINE_CELLS: f64 = 1.5;

/// Frames are far from where they were if their points moved by more than this share of a cell.
const LEAST_MOTION: f64 = 0.1;

/// Edge of the cells in which points are pooled to align all frames to each other: as a share of the other
/// cells, in pixels, and as a share of the box, the largest of these. Their normals need some pixels.
const FINE_SHARE: f64 = 0.4;
const FINE_PIXELS: f64 = 3.0;
const FINE_SHARE_OF_BOX: f64 = 0.01;

impl KnownSurface {
    /// Returns an empty surface. Fails if the configuration is out of range.
    pub fn new(config: RegistrationConfig) -> Result<Self, Error> {
        config.check()?;
        let spacing = config.spacing.unwrap_or(RegistrationConfig::DEFAULT_SPACING);
        let lattice = Lattice::new(spacing)?;
        let (slots, pools, tree, views) = Default::default();
        Ok(Self { config, spacing, lattice, slots, pools, tree, views, prior: PosePrior::new(&config) })
    }

    /// Returns an empty surface with the same configuration.
    pub(crate) fn without_points(&self) -> Self {
        Self::new(self.config).expect("the configuration was checked")
    }

    /// Returns the number of frames that were added.
    pub(crate) fn n_frames(&self) -> usize {
        self.views.len()
    }

    /// Returns the number of known points.
    pub fn n_points(&self) -> usize {
        self.pools.len()
    }

    /// Returns the known points, the mean of each cell, in the order in which the cells were first met.
    pub fn points(&self) -> Vec<SurfacePoint> {
        self.pools.iter().map(CellPool::mean).collect()
    }

    /// Returns the points in a pose with their nearest known ones that face the same way within `reach`
    /// metres, in the order of the points: the pairs for [`align`](super::align).
    pub fn pairs(
        &self,
        points: &[SurfacePoint],
        pose: &Pose,
        reach: f64,
        cancel: &Cancel,
    ) -> Result<Vec<Pair>, Cancelled> {
        pairs(points, &self.tree, pose, reach, cancel)
    }

    /// Adds the surface that a frame shows in and around a box (world coordinates, finite), unless cancelled.
    /// `given` is the frame's pose before alignment.
    pub fn add(
        &mut self,
        frame: &Frame,
        given: &Pose,
        bounds: Aabb,
        cancel: &Cancel,
    ) -> Result<(), Cancelled> {
        let around = self.around(bounds);
        let points = surface_points(frame, around, self.spacing, cancel)?;
        let fine_spacing = self.fine_spacing(frame, bounds);
        let shown = surface_points(frame, around, fine_spacing, cancel)?;
        let camera = FrameCamera::new(frame.clone());
        let joint = JointView::new(shown, camera.pose(), self.prior_mean(frame, given), cancel)?;
        let view = KnownView { far_pose: joint.pose, joint, camera, points, fine_spacing };
        let (mut slots, mut pools) = (self.slots.clone(), self.pools.clone());
        view.pool(&self.lattice, &mut slots, &mut pools);
        self.tree = tree(&pools, cancel)?;
        (self.slots, self.pools) = (slots, pools);
        self.views.push(view);
        Ok(())
    }

    /// Aligns all frames to each other at once, unless cancelled, by what they show in and near a box (world
    /// coordinates, finite): the errors of a closed chain of frames are shared by all. Given poses have
    /// errors of their own and one in common, such as that of a hand-eye calibration; see [`GivenPoses`] for
    /// what determines the common pose. Returns `None` if there are fewer than two frames.
    pub fn realign(&mut self, bounds: Aabb, cancel: &Cancel) -> Result<Option<Realigned>, Cancelled> {
        if self.views.len() < 2 {
            return Ok(None);
        }
        let near = Aabb { min: bounds.min - self.spacing, max: bounds.max + self.spacing };
        let coarsest = self.views.iter().map(|view| view.fine_spacing).fold(0.0, f64::max);
        let reach = SearchReach { last: REACH_IN_FINE_CELLS * coarsest, first: self.reach().last };
        let (mut views, mut prior) = (self.views.clone(), self.prior);
        let mut joint: Vec<_> = views.iter_mut().map(|view| &mut view.joint).collect();
        let fit = joint::align(&mut joint, &mut prior, near, reach, cancel)?;
        let (last, earlier) = views.split_last_mut().expect("there are frames");
        let moved = earlier.iter().map(|view| view.joint.moved_from(&view.far_pose, near));
        let is_far = moved.fold(0.0, f64::max) > LEAST_MOTION * self.spacing;
        last.far_pose = last.joint.pose;
        if is_far {
            earlier.iter_mut().for_each(|view| view.far_pose = view.joint.pose);
        }
        let (mut slots, mut pools) = Default::default();
        views.iter().for_each(|view| view.pool(&self.lattice, &mut slots, &mut pools));
        self.tree = tree(&pools, cancel)?;
        (self.slots, self.pools, self.views, self.prior) = (slots, pools, views, prior);
        let poses = self.views.iter().map(|view| view.joint.pose).collect();
        Ok(Some(Realigned { poses, is_far, fit }))
    }

    /// Aligns the surface that a frame shows in and around a box (world coordinates, finite) to the known
    /// surface, unless cancelled.
    pub fn register(&self, frame: &Frame, bounds: Aabb, cancel: &Cancel) -> Result<Registration, Cancelled> {
        self.fitting(frame, bounds, cancel)?.register()
    }

    /// Compares a frame in its given pose with the known surface, to learn how far apart they are.
    pub(crate) fn compare(
        &self,
        frame: &Frame,
        bounds: Aabb,
        cancel: &Cancel,
    ) -> Result<PoseComparison, Cancelled> {
        self.fitting(frame, bounds, cancel)?.nearby()
    }

    fn fitting<'a>(
        &'a self,
        frame: &Frame,
        bounds: Aabb,
        cancel: &'a Cancel,
    ) -> Result<Fitting<'a>, Cancelled> {
        let points = surface_points(frame, self.around(bounds), self.spacing, cancel)?;
        let known = self.pools.iter().map(|pool| pool.position / pool.n).collect();
        let earlier = self.views.iter().map(|view| view.camera.at(view.joint.pose)).collect();
        let (config, reach, tree) = (&self.config, self.reach(), &self.tree);
        let camera = FrameCamera::new(frame.clone());
        Ok(Fitting { config, reach, points, camera, known, tree, earlier, cancel })
    }

    fn reach(&self) -> SearchReach {
        let last = REACH_IN_CELLS * self.spacing;
        SearchReach { first: self.config.position_uncertainty.max(last), last }
    }

    /// The edge of the cells in which points of a frame are pooled to align all frames, metres.
    fn fine_spacing(&self, frame: &Frame, bounds: Aabb) -> f64 {
        let pixel = frame.world_from_camera().translation().distance(bounds.center())
            / frame.intrinsics().focal().min_element();
        let fine = (FINE_SHARE * self.spacing)
            .max(FINE_PIXELS * pixel)
            .max(FINE_SHARE_OF_BOX * bounds.longest_side());
        fine.max(Lattice::MIN_VOXEL_SIZE).min(self.spacing)
    }

    /// The mean of a frame's pose: the given one, or where it was placed if that was found by alignment.
    fn prior_mean(&self, frame: &Frame, given: &Pose) -> Pose {
        if self.config.given_poses == GivenPoses::Tracked { frame.world_from_camera() } else { *given }
    }

    /// A frame in a wrong pose shows the surface outside the box.
    fn around(&self, bounds: Aabb) -> Aabb {
        let margin = self.config.position_uncertainty;
        Aabb { min: bounds.min - margin, max: bounds.max + margin }
    }
}

impl KnownView {
    /// Adds the points to the pools of their cells.
    fn pool(&self, lattice: &Lattice, slots: &mut FxHashMap<(IVec3, u8), usize>, pools: &mut Vec<CellPool>) {
        for point in self.points.iter().map(|point| point.moved(&self.joint.pose)) {
            let slot = *slots.entry((lattice.key(point.position), side(point.normal))).or_insert(pools.len());
            if slot == pools.len() {
                pools.push(CellPool::default());
            }
            pools[slot].add(&point);
        }
    }
}

fn tree(pools: &[CellPool], cancel: &Cancel) -> Result<PointTree, Cancelled> {
    let points: Vec<SurfacePoint> = pools.iter().map(CellPool::mean).collect();
    PointTree::new(&points, cancel)
}

impl CellPool {
    fn add(&mut self, point: &SurfacePoint) {
        self.n += 1.0;
        self.position += point.position;
        self.normal += point.normal;
    }

    fn mean(&self) -> SurfacePoint {
        // The sum does not vanish: all normals of one side have their largest component along the same axis,
        // with the same sign.
        SurfacePoint { position: self.position / self.n, normal: self.normal.normalize() }
    }
}

/// Returns which of six sides a surface faces: the axis nearest to its normal, and the sign.
fn side(normal: DVec3) -> u8 {
    let axis = normal.abs().max_position();
    2 * axis as u8 + (normal[axis] < 0.0) as u8
}
