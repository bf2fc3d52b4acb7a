use crate::geometry::{Aabb, Pose};
use crate::registration::{
    Agreement, GivenPoses, KnownSurface, PoseFit, Realigned, Registration, RegistrationConfig,
    RegistrationMode,
};
use crate::sensor::Frame;
use crate::{Cancel, Cancelled, Error};

/// Aligns each frame to the surface shown by those before it, if configured: from the first frame on, or once
/// the given poses disagree.
#[derive(Clone, Debug)]
pub(super) struct Alignment {
    /// `None` if registration is off.
    known: Option<KnownSurface>,
    /// Whether frames are aligned, rather than only compared until the given poses prove wrong.
    is_active: bool,
    /// Edge of the cells in which points are pooled, metres.
    spacing: f64,
    given: PoseErrors,
    agreement: Agreement,
    /// How well the frames fit together; `None` unless all were aligned with the last one.
    fit: Option<PoseFit>,
    /// Whether given poses come from a source other than alignment to the known surface.
    is_proof: bool,
}

/// Errors of the given poses of the frames that fitted.
#[derive(Clone, Copy, Debug)]
struct PoseErrors {
    /// Error up to which they count as correct, root mean square at the corners of the box, metres.
    tolerance: f64,
    n: usize,
    /// Sum of the squared errors.
    sum_sq: f64,
}

/// Minimum number of frames that prove anything about the poses of others.
const LEAST_PROOF: usize = 2;

/// Number of frames after which given poses that agreed are believed: all frames are no longer aligned to
/// learn whether they are wrong.
const MOST_COMPARED: usize = 12;

impl Alignment {
    /// Returns an alignment without known surface. Points are pooled in voxels unless configured otherwise.
    /// Fails if the configuration is out of range.
    pub fn new(config: RegistrationConfig, voxel_size: f64) -> Result<Self, Error> {
        let spacing = config.spacing.unwrap_or(RegistrationConfig::DEFAULT_SPACING.min(voxel_size));
        let config = RegistrationConfig { spacing: Some(spacing), ..config };
        let mode = config.mode();
        let known = (mode != RegistrationMode::Off).then(|| KnownSurface::new(config)).transpose()?;
        // Half a cell of pooled points: an alignment itself is off by half a millimetre in cells of 5 mm.
        let given = PoseErrors { tolerance: 0.5 * spacing, n: 0, sum_sq: 0.0 };
        let is_proof = config.given_poses != GivenPoses::Tracked;
        let agreement = Agreement::default();
        Ok(Self {
            known,
            is_active: mode == RegistrationMode::On,
            spacing,
            given,
            agreement,
            fit: None,
            is_proof,
        })
    }

    /// Returns the state before the first frame, but keeps the errors of the given poses.
    pub fn without_surface(&self) -> Self {
        Self { known: self.known.as_ref().map(KnownSurface::without_points), fit: None, ..*self }
    }

    /// Whether frames are aligned.
    pub fn is_active(&self) -> bool {
        self.is_active
    }

    /// Compares a new frame in its given pose with those before it, as long as frames are not aligned.
    /// Returns the distance between their surfaces, metres, once it shows that the given poses are wrong.
    pub fn compare(
        &mut self,
        frame: &Frame,
        bounds: Option<Aabb>,
        cancel: &Cancel,
    ) -> Result<Option<f64>, Cancelled> {
        let known = self.known.as_ref().filter(|known| !self.is_active && known.n_points() > 0);
        let Some((known, bounds)) = known.zip(bounds) else { return Ok(None) };
        let found = known.compare(frame, bounds, cancel)?;
        let apart = self.agreement.add(&found, self.spacing);
        if apart.is_some() || known.n_frames() >= MOST_COMPARED {
            return Ok(apart);
        }
        // A single frame is compared with a surface that wrong poses have smeared; all frames with each other
        // show smaller errors.
        let mut all = known.clone();
        all.add(frame, &frame.world_from_camera(), bounds, cancel)?;
        let realigned = all.realign(bounds, cancel)?;
        Ok(realigned.and_then(|realigned| realigned.fit.error_of_given(self.spacing)))
    }

    /// Aligns a frame; `None` while there is no known surface.
    pub fn register(
        &self,
        frame: &Frame,
        bounds: Option<Aabb>,
        cancel: &Cancel,
    ) -> Result<Option<Registration>, Cancelled> {
        let known = self.known.as_ref().filter(|known| self.is_active && known.n_points() > 0);
        known.zip(bounds).map(|(known, bounds)| known.register(frame, bounds, cancel)).transpose()
    }

    /// Whether all given poses seem correct: a frame that overlaps no other then stays in its given pose.
    pub fn trusts_given_poses(&self) -> bool {
        self.given.are_right()
    }

    /// Adds a frame in its final pose, given or aligned.
    pub fn remember(
        &mut self,
        frame: &Frame,
        given: &Pose,
        bounds: Option<Aabb>,
        registration: Option<Registration>,
        cancel: &Cancel,
    ) -> Result<(), Cancelled> {
        let (Some(known), Some(bounds)) = (&mut self.known, bounds) else { return Ok(()) };
        if self.is_proof && registration.is_some_and(|registration| registration.fits()) {
            self.given.add(&(frame.world_from_camera() * given.inverse()), bounds);
        }
        known.add(frame, given, bounds, cancel)
    }

    /// Aligns all frames to each other. Returns their poses in the order of [`remember`](Self::remember), or
    /// `None` if they stay. Frames from before there was a box are not included.
    pub fn realign(&mut self, bounds: Option<Aabb>, cancel: &Cancel) -> Result<Option<Realigned>, Cancelled> {
        let realigned = match (&mut self.known, bounds) {
            (Some(known), Some(bounds)) if self.is_active => known.realign(bounds, cancel)?,
            _ => None,
        };
        self.fit = realigned.as_ref().map(|realigned| realigned.fit.clone());
        Ok(realigned)
    }

    /// How well the frames fit together; `None` unless all were aligned with the last one.
    pub fn fit(&self) -> Option<&PoseFit> {
        self.fit.as_ref()
    }
}

impl PoseErrors {
    fn add(&mut self, motion: &Pose, bounds: Aabb) {
        let corners = bounds.corners().map(|corner| motion.transform_point(corner).distance_squared(corner));
        self.n += 1;
        self.sum_sq += corners.iter().sum::<f64>() / corners.len() as f64;
    }

    fn are_right(&self) -> bool {
        self.n >= LEAST_PROOF && self.sum_sq <= self.tolerance.powi(2) * self.n as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DQuat, DVec3};

    #[test]
    fn given_poses_are_right_once_two_were_and_while_their_errors_are_small() {
        let bounds = Aabb::cube(DVec3::X, 0.1);
        let moved = |shift: f64| Pose::new(DQuat::IDENTITY, DVec3::new(0.0, shift, 0.0)).unwrap();
        let mut given = PoseErrors { tolerance: 0.0025, n: 0, sum_sq: 0.0 };
        assert!(!given.are_right(), "nothing is known");
        given.add(&moved(0.0), bounds);
        assert!(!given.are_right(), "one may be right by chance");
        given.add(&moved(0.003), bounds);
        assert!(given.are_right());
        given.add(&moved(0.004), bounds);
        assert!(!given.are_right());
        let turned = Pose::new(DQuat::from_rotation_z(0.01), DVec3::ZERO).unwrap();
        let mut given = PoseErrors { n: 1, sum_sq: 0.0, ..given };
        given.add(&turned, bounds);
        assert!(!given.are_right(), "turned by a centimetre at the box");
    }
}
