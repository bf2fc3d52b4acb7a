use crate::geometry::Aabb;
use crate::registration::{KnownSurface, Registration};
use crate::sensor::Frame;

/// Aligns each frame to the surface that those before it have shown, where a session is asked to.
#[derive(Debug)]
pub(super) struct Alignment {
    /// None without registration.
    known: Option<KnownSurface>,
}

impl Alignment {
    pub fn new(known: Option<KnownSurface>) -> Self {
        Self { known }
    }

    /// Aligns a frame; none while nothing is known that it could be aligned to.
    pub fn register(&self, frame: &Frame, bounds: Option<Aabb>) -> Option<Registration> {
        let known = self.known.as_ref().filter(|known| known.n_points() > 0)?;
        Some(known.register(frame, bounds?))
    }

    /// Takes in a frame in its final pose, unless it does not fit: what it shows may lie anywhere.
    pub fn remember(&mut self, frame: &Frame, bounds: Option<Aabb>, registration: Option<Registration>) {
        if let (Some(known), Some(bounds)) = (&mut self.known, bounds)
            && registration.is_none_or(|registration| registration.fits())
        {
            known.add(frame, bounds);
        }
    }
}
