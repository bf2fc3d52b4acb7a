use super::config::SessionConfig;
use crate::Error;
use crate::geometry::Aabb;
use crate::planner::Situation;
use crate::sensor::{DepthRange, Frame, Intrinsics, SurfaceNoise};
use crate::surface::{MeasuredCells, SurfaceLooks};
use crate::{Cancel, Cancelled};

/// Number of looks, straight on from the least distance, that must reach a goal.
const LOOKS: f64 = 3.0;

/// Least distance assumed for cameras without one, metres.
const LEAST_DISTANCE: f64 = 0.1;

/// Fails if three looks straight on, from the least distance of a camera with this error, miss the goal
/// (standard deviation, metres) in voxels of this size (metres).
pub(super) fn check_reachable(
    goal: f64,
    camera: &SurfaceNoise,
    voxel_size: f64,
    intrinsics: &Intrinsics,
    range: DepthRange,
) -> Result<(), Error> {
    let (distance, focal) = (range.min.max(LEAST_DISTANCE), intrinsics.focal().x);
    let n = (voxel_size * focal / distance).powi(2);
    let best = (camera.of_look(camera.of_pixel(distance, 1.0, focal), n) / LOOKS).sqrt();
    if best <= goal {
        return Ok(());
    }
    // Rounded up, so that the printed value can be reached.
    Err(Error::UnreachableGoal { goal_mm: goal * 1e3, best_mm: (best * 1e6).ceil() / 1e3, distance })
}

/// How accurately and how often surface was measured so far, against the goals.
#[derive(Clone, Debug)]
pub(super) struct MeasuredQuality {
    /// The cells and the goal, a standard deviation in metres.
    errors: Option<(MeasuredCells, f64)>,
    looks: Option<SurfaceLooks>,
    /// The share of cells that reach the goals after each step.
    shares: Vec<f64>,
}

impl MeasuredQuality {
    /// Returns the state before the first frame; `None` if there is no goal. The configuration must have been
    /// checked.
    pub fn new(config: &SessionConfig) -> Result<Option<Self>, Error> {
        let &SessionConfig { goal, looks, surface_error, voxel_size, .. } = config;
        let errors = |goal| MeasuredCells::new(voxel_size, surface_error).map(|cells| (cells, goal));
        let errors = goal.map(errors).transpose()?;
        let looks = looks.map(|goal| SurfaceLooks::new(voxel_size, goal)).transpose()?;
        let is_any = errors.is_some() || looks.is_some();
        Ok(is_any.then_some(Self { errors, looks, shares: Vec::new() }))
    }

    /// Adds the measurements and the goals to the situation.
    pub fn add_to<'a>(&'a self, situation: Situation<'a>) -> Situation<'a> {
        let situation = match &self.errors {
            Some((measured, goal)) => situation.with_goal(measured, *goal),
            None => situation,
        };
        match &self.looks {
            Some(looks) => situation.with_looks(looks),
            None => situation,
        }
    }

    /// Adds a frame.
    pub fn add(&mut self, frame: &Frame, bounds: Option<Aabb>, cancel: &Cancel) -> Result<(), Cancelled> {
        let Some(bounds) = bounds else { return Ok(()) };
        self.errors.as_mut().map_or(Ok(()), |(measured, _)| measured.add(frame, bounds, cancel))?;
        self.looks.as_mut().map_or(Ok(()), |looks| looks.add(frame, bounds, cancel))
    }

    /// Replaces all frames by these.
    pub fn renew(
        &mut self,
        frames: &[Frame],
        bounds: Option<Aabb>,
        cancel: &Cancel,
    ) -> Result<(), Cancelled> {
        self.errors.iter_mut().for_each(|(measured, _)| measured.clear());
        self.looks.iter_mut().for_each(SurfaceLooks::clear);
        frames.iter().try_for_each(|frame| self.add(frame, bounds, cancel))
    }

    /// Ends a step. Returns the share of measured cells that reach all goals, 0..=1, 0 without any.
    pub fn end_step(&mut self) -> f64 {
        let share = match (&self.errors, &self.looks) {
            (Some((measured, goal)), looks) => {
                let has_looks = |key| looks.as_ref().is_none_or(|looks| looks.is_done(key));
                share(measured.errors().map(|(key, error)| error <= *goal && has_looks(key)))
            }
            (None, Some(looks)) => share(looks.are_done()),
            (None, None) => 0.0,
        };
        self.shares.push(share);
        share
    }

    /// Returns the share of measured cells that reach all goals, 0..=1, after the last step; 0 before the
    /// first.
    pub fn share_at_goal(&self) -> f64 {
        self.shares.last().copied().unwrap_or(0.0)
    }

    /// Returns the rise of the share at the goals over the last `n` steps; `None` if there were fewer.
    pub fn progress(&self, n: usize) -> Option<f64> {
        let (last, before) = self.shares.split_last()?;
        Some(last - before[before.len().checked_sub(n)?])
    }
}

/// Returns the share of cells that reach the goals, 0..=1, 0 without any.
fn share(are_done: impl Iterator<Item = bool>) -> f64 {
    let (n, n_done) = are_done.fold((0_u32, 0_u32), |(n, n_done), is_done| (n + 1, n_done + is_done as u32));
    f64::from(n_done) / f64::from(n.max(1))
}
