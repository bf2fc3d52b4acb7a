use crate::geometry::Aabb;
use crate::registration::{KnownSurface, Registration};
use crate::sensor::Frame;
use crate::{Cancel, Cancelled};

/// Aligns each frame to the surface shown by those before it, if the session is configured to.
#[derive(Clone, Debug)]
pub(super) struct Alignment {
    /// None without registration.
    known: Option<KnownSurface>,
}

impl Alignment {
    pub fn new(known: Option<KnownSurface>) -> Self {
        Self { known }
    }

    /// Aligns a frame; none while there is no known surface to align it to.
    pub fn register(
        &self,
        frame: &Frame,
        bounds: Option<Aabb>,
        cancel: &Cancel,
    ) -> Result<Option<Registration>, Cancelled> {
        let known = self.known.as_ref().filter(|known| known.n_points() > 0);
        known.zip(bounds).map(|(known, bounds)| known.register(frame, bounds, cancel)).transpose()
    }

    /// Adds a frame in its final pose, unless it does not fit: its surface may lie anywhere.
    pub fn remember(
        &mut self,
        frame: &Frame,
        bounds: Option<Aabb>,
        registration: Option<Registration>,
        cancel: &Cancel,
    ) -> Result<(), Cancelled> {
        if let (Some(known), Some(bounds)) = (&mut self.known, bounds)
            && registration.is_none_or(|registration| registration.fits())
        {
            known.add(frame, bounds, cancel)?;
        }
        Ok(())
    }
}
