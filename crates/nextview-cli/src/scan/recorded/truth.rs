use super::RecordingConfig;
use crate::Failure;
use crate::scan::finished::Measured;
use crate::scan::setting::voxel_block;
use crate::scan::{ScanConfig, Truth};
use glam::DVec3;
use nextview::geometry::{Aabb, Lattice};
use nextview::sensor::Frame;
use nextview::session::{Session, SessionConfig};
use nextview_recording::{Recording, RecordingError, read_transform};
use nextview_sim::accuracy::Accuracy;
use nextview_sim::gauge::Measures;
use nextview_sim::mesh::{self, TriangleMesh, UnitSource};
use nextview_sim::quality::TrueSurface;
use nextview_sim::surface::SurfaceCoverage;
use nextview_sim::truth::{ObjectVoxels, TrueVisibility};
use rayon::prelude::*;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

/// A sample of the surface was seen if a point was measured as near as this, metres.
const SEEN: f64 = 0.002;

/// The true object in the world of the recording.
pub(super) struct TrueShape {
    mesh: TriangleMesh,
    /// What points and the final model are measured against.
    pub surface: TrueSurface,
    voxels: ObjectVoxels,
    /// How the file's numbers became metres, where that was not stated.
    pub note: Option<String>,
}

impl TrueShape {
    /// None if the configuration names no mesh.
    pub fn load(
        config: &ScanConfig,
        recording: &RecordingConfig,
        session: &SessionConfig,
    ) -> Result<Option<Self>, Failure> {
        let Some(file) = &recording.truth else { return Ok(None) };
        let (mesh, scaling) = mesh::load(Path::new(file))?.to_metres(config.unit.into())?;
        let note =
            (scaling.source == UnitSource::Guessed).then(|| format!("note: {scaling}; say so with --unit"));
        let mesh = match &recording.truth_from_world {
            Some(file) => mesh.transformed(&read_transform(Path::new(file))?.inverse())?,
            None => mesh,
        };
        // As a simulation's planner is told: a tenth larger than the object and two voxels on each side.
        let half = 0.55 * mesh.bounds().longest_side() + 2.0 * session.voxel_size;
        let block = voxel_block(session, &Aabb::cube(mesh.bounds().center(), half))?;
        let voxels = ObjectVoxels::new(&mesh, Lattice::new(session.voxel_size)?, block);
        Ok(Some(Self { surface: TrueSurface::new(&mesh), voxels, mesh, note }))
    }

    /// What every frame shows of the surface.
    pub fn shown_by(&self, recording: &Recording) -> Result<Truth, Failure> {
        let start = Instant::now();
        let nothing = SurfaceCoverage::new(&self.mesh);
        let shown = recording.frames.par_iter().map(|frame| {
            let mut coverage = nothing.clone();
            coverage.add(&frame.load()?);
            Ok(coverage.within(SEEN))
        });
        let shown: Vec<_> = shown.collect::<Result<_, RecordingError>>()?;
        let visibility = TrueVisibility::of_seen(shown).ok_or_else(|| {
            Failure::data(
                "no frame has a point within 2 mm of the true object, so that they do not belong together",
            )
            .with_hint("--truth-from-world states where the mesh is, --unit its unit")
        })?;
        Ok(Truth { visibility: Arc::new(visibility), time: start.elapsed() })
    }

    /// Nothing is measured yet.
    pub fn gauge(&self) -> Gauge<'_> {
        Gauge { truth: self, surface: SurfaceCoverage::new(&self.mesh), distances: Vec::new() }
    }
}

/// Measures a scan, frame by frame.
pub(super) struct Gauge<'a> {
    truth: &'a TrueShape,
    surface: SurfaceCoverage,
    /// Of all points that were in the box when they were measured.
    distances: Vec<f64>,
}

impl Gauge<'_> {
    /// How the scan stands after this frame.
    pub fn measure(&mut self, session: &Session, frame: &Frame) -> Measured {
        let Self { truth, surface, distances } = self;
        let points: Vec<DVec3> =
            session.bounds().into_iter().flat_map(|bounds| frame.points_in(bounds)).collect();
        distances.par_extend(points.par_iter().map(|point| truth.surface.distance().at(*point)));
        surface.add(frame);
        let measures = Measures {
            voxels: truth.voxels.compare(&session.map().snapshot(truth.voxels.block())),
            n_seen: surface.within(SEEN).count_ones(..),
            surface_coverage: surface.shares(),
            misplacement: None,
        };
        Measured { truth: Some(measures), accuracy: Accuracy::of(distances) }
    }
}
