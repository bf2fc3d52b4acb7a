use crate::Error;
use crate::geometry::Aabb;
use crate::sensor::{DepthRange, Frame, Intrinsics, SurfaceError};
use crate::surface::MeasuredCells;
use crate::{Cancel, Cancelled};

/// Number of looks straight on from the least distance that must reach a goal.
const LOOKS: f64 = 3.0;

/// The least distance of cameras without one, metres.
const LEAST_DISTANCE: f64 = 0.1;

/// Fails if three looks straight on, from the least distance of a camera of this error, do not reach the goal
/// (standard deviation, metres) in voxels of this size (metres).
pub(super) fn check_reachable(
    goal: f64,
    camera: &SurfaceError,
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
    // Rounded up, so that it can be reached as it stands.
    Err(Error::UnreachableGoal { goal_mm: goal * 1e3, best_mm: (best * 1e6).ceil() / 1e3, distance })
}

/// How well surface was measured so far, beside a goal.
#[derive(Clone, Debug)]
pub(super) struct Quality {
    /// Standard deviation, metres.
    pub goal: f64,
    pub measured: MeasuredCells,
    camera: SurfaceError,
    voxel_size: f64,
    /// The share of cells at the goal after each step.
    shares: Vec<f64>,
}

impl Quality {
    /// Nothing was measured, in voxels of a valid size; for a checked goal.
    pub fn new(goal: f64, camera: SurfaceError, voxel_size: f64) -> Result<Self, Error> {
        let measured = MeasuredCells::new(voxel_size, camera)?;
        Ok(Self { goal, measured, camera, voxel_size, shares: Vec::new() })
    }

    /// Adds a frame.
    pub fn add(&mut self, frame: &Frame, bounds: Option<Aabb>, cancel: &Cancel) -> Result<(), Cancelled> {
        bounds.map_or(Ok(()), |bounds| self.measured.add(frame, bounds, cancel))
    }

    /// Forgets all frames and adds these.
    pub fn renew(
        &mut self,
        frames: &[Frame],
        bounds: Option<Aabb>,
        cancel: &Cancel,
    ) -> Result<(), Cancelled> {
        let empty = MeasuredCells::new(self.voxel_size, self.camera);
        self.measured = empty.expect("both were checked");
        frames.iter().try_for_each(|frame| self.add(frame, bounds, cancel))
    }

    /// Ends a step; returns the share of measured cells that are at the goal, 0..=1, 0 without any.
    pub fn end_step(&mut self) -> f64 {
        let (n, n_fine) = self
            .measured
            .errors()
            .fold((0, 0), |(n, n_fine), error| (n + 1, n_fine + (error <= self.goal) as usize));
        let share = n_fine as f64 / f64::from(n.max(1));
        self.shares.push(share);
        share
    }

    /// How much the share at the goal rose over the last `n` steps; none if there were fewer.
    pub fn progress(&self, n: usize) -> Option<f64> {
        let (last, before) = self.shares.split_last()?;
        Some(last - before[before.len().checked_sub(n)?])
    }
}
