use crate::geometry::Aabb;
use crate::registration::{KnownSurface, Registration};
use crate::sensor::Frame;

/// Aligns each frame to the surface shown by those before it, if the session is configured to.
#[derive(Debug)]
pub(super) struct Alignment {
    /// None without registration.
    known: Option<KnownSurface>,
}

impl Alignment {
    pub fn new(known: Option<KnownSurface>) -> Self {
        Self { known }
    }

    /// Aligns a frame; none while there is no known surface to align it to.
    pub fn register(&self, frame: &Frame, bounds: Option<Aabb>) -> Option<Registration> {
        let known = self.known.as_ref().filter(|known| known.n_points() > 0)?;
        Some(known.register(frame, bounds?))
    }

    /// Adds a frame in its final pose, unless it does not fit: its surface may lie anywhere.
    pub fn remember(&mut self, frame: &Frame, bounds: Option<Aabb>, registration: Option<Registration>) {
        if let (Some(known), Some(bounds)) = (&mut self.known, bounds)
            && registration.is_none_or(|registration| registration.fits())
        {
            known.add(frame, bounds);
        }
    }
}
