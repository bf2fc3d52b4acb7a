use crate::geometry::Plane;
use crate::map::Snapshot;
use crate::registration::{KnownSurface, RegistrationConfig, SurfacePoint};
use crate::sensor::Frame;
use crate::{Cancel, Cancelled};
use glam::DVec3;

/// An object as the frames of one placement have shown it.
#[derive(Clone, Debug)]
pub struct ShownObject {
    frames: Vec<Frame>,
    surface: KnownSurface,
    points: Vec<SurfacePoint>,
    snapshot: Snapshot,
    table: Plane,
}

impl ShownObject {
    /// Creates the object from frames whose surface is that of the object alone, with the map that they make
    /// and the table that the object stood on.
    pub fn new(
        frames: Vec<Frame>,
        snapshot: Snapshot,
        table: Plane,
        cancel: &Cancel,
    ) -> Result<Self, Cancelled> {
        let lattice = snapshot.lattice();
        let config = RegistrationConfig { spacing: Some(lattice.voxel_size()), ..Default::default() };
        let mut surface = KnownSurface::new(config).expect("a lattice's voxels are a valid spacing");
        let bounds = lattice.bounds(&snapshot.block());
        for frame in &frames {
            surface.add(frame, &frame.world_from_camera(), bounds, cancel)?;
        }
        let points = surface.points();
        Ok(Self { frames, surface, points, snapshot, table })
    }

    /// Its frames, oldest first, with only the object left. A ray that ended on something else counts as one
    /// that met nothing, or, where the object may be behind it, as one that measured nothing.
    pub fn frames(&self) -> &[Frame] {
        &self.frames
    }

    /// Points of the measured surface, one for each side in each cell with edges of a voxel.
    pub fn points(&self) -> &[SurfacePoint] {
        &self.points
    }

    /// The map of the box around it.
    pub fn snapshot(&self) -> &Snapshot {
        &self.snapshot
    }

    /// The table that it stood on.
    pub fn table(&self) -> Plane {
        self.table
    }

    /// The measured surface, for aligning others.
    pub(super) fn surface(&self) -> &KnownSurface {
        &self.surface
    }

    /// Whether a point of the object cannot be here: in the table, or in space seen to be free, together with
    /// everything up to a voxel away.
    pub(super) fn rules_out(&self, point: DVec3) -> bool {
        let voxel_size = self.snapshot.lattice().voxel_size();
        self.table.height(point) < -voxel_size || self.snapshot.is_free_around(point)
    }
}
