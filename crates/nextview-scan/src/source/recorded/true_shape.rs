use crate::source::session_config::voxel_block;
use crate::source::simulated::Truth;
use crate::{Fault, RecordingConfig, ScanConfig, StepRecord};
use fixedbitset::FixedBitSet;
use glam::DVec3;
use nextview::Cancel;
use nextview::geometry::{Lattice, Pose};
use nextview::object::planning_box;
use nextview::sensor::Frame;
use nextview::session::{Session, SessionConfig};
use nextview_recording::{RecordedFrame, Recording, read_transform};
use nextview_sim::accuracy::Accuracy;
use nextview_sim::mesh::{self, TriangleMesh, UnitSource};
use nextview_sim::quality::{ReachableSurface, TrueSurface};
use nextview_sim::surface::SurfaceCoverage;
use nextview_sim::truth::{ObjectVoxels, TrueVisibility};
use rayon::prelude::*;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

/// Maximum distance in metres from a surface sample to a measured point for the sample to count as seen.
const SEEN: f64 = 0.002;

/// The true object in the world of the recording.
pub(super) struct TrueShape {
    mesh: TriangleMesh,
    /// The true surface, for evaluating points and the final model.
    pub surface: TrueSurface,
    voxels: ObjectVoxels,
    /// Note on the conversion of the file's numbers to metres, if the unit was not stated.
    pub note: Option<String>,
}

impl TrueShape {
    /// Loads the mesh; `None` if none is configured.
    pub fn load(
        config: &ScanConfig,
        recording: &RecordingConfig,
        session: &SessionConfig,
    ) -> Result<Option<Self>, Fault> {
        let Some(file) = &recording.truth else { return Ok(None) };
        let (mesh, scaling) = mesh::load(Path::new(file))?.to_metres(config.unit.into())?;
        let note =
            (scaling.source == UnitSource::Guessed).then(|| format!("{scaling}; set `unit` to be sure"));
        let mesh = match &recording.truth_from_world {
            Some(file) => mesh.transformed(&read_transform(Path::new(file))?.inverse())?,
            None => mesh,
        };
        let block = voxel_block(session, &planning_box(&mesh.bounds(), session.voxel_size))?;
        let voxels = ObjectVoxels::new(&mesh, Lattice::new(session.voxel_size)?, block);
        Ok(Some(Self { surface: TrueSurface::new(&mesh), voxels, mesh, note }))
    }

    /// The part of the surface that each frame shows. Fails if cancelled.
    pub fn shown_by(&self, recording: &Recording, cancel: &Cancel) -> Result<Truth, Fault> {
        let start = Instant::now();
        let nothing = SurfaceCoverage::new(&self.mesh);
        let shown_by = |frame: &RecordedFrame| {
            cancel.check()?;
            let (mut coverage, frame) = (nothing.clone(), frame.load()?);
            coverage.add(&frame);
            Ok((coverage.within(SEEN), self.voxels.seen_in(&frame)))
        };
        let (mut shown, mut hit) = (Vec::new(), Vec::new());
        for group in recording.groups() {
            let of_group = group.par_iter().map(shown_by).collect::<Result<Vec<_>, Fault>>()?;
            for (coverage, voxels) in of_group {
                shown.push(coverage);
                hit.push(voxels);
            }
        }
        let visibility = TrueVisibility::of_seen(shown).ok_or_else(|| {
            Fault::data("no frame has a point within 2 mm of the true object, so they do not match")
                .with_remedy("`recording.truth_from_world` states where the mesh is, `unit` its unit")
        })?;
        let mut reachable_voxels = FixedBitSet::with_capacity(self.voxels.len());
        hit.iter().for_each(|voxels| reachable_voxels.union_with(voxels));
        let samples = visibility.reachable();
        let reachable_surface =
            ReachableSurface::of((0..samples.len()).map(|sample| samples.contains(sample)));
        let visibility = Arc::new(visibility);
        Ok(Truth { visibility, reachable_voxels, reachable_surface, time: start.elapsed() })
    }

    /// The progress of a scan before its first frame, with the object voxels that any frame shows.
    pub fn progress<'a>(&'a self, reachable: Option<&'a FixedBitSet>) -> RecordedEvaluation<'a> {
        let surface = SurfaceCoverage::new(&self.mesh);
        RecordedEvaluation { truth: self, reachable, surface, distances: Vec::new(), counted: Vec::new() }
    }

    /// Number of object voxels.
    pub fn n_voxels(&self) -> usize {
        self.voxels.len()
    }
}

/// Evaluates a recorded scan against ground truth, frame by frame.
pub(super) struct RecordedEvaluation<'a> {
    truth: &'a TrueShape,
    reachable: Option<&'a FixedBitSet>,
    surface: SurfaceCoverage,
    /// Distances of all points that were in the box when their frame was counted.
    distances: Vec<f64>,
    /// Poses of the mapped frames whose points are counted.
    counted: Vec<Pose>,
}

impl RecordedEvaluation<'_> {
    /// Fills in the scan's progress with the frames in the map; returns the number of surface samples seen.
    pub fn measure(&mut self, session: &Session, record: &mut StepRecord) -> usize {
        let Self { truth, reachable, surface, distances, counted } = self;
        let mapped: Vec<_> = session.frames().iter().map(Frame::world_from_camera).collect();
        // Registration may have moved earlier frames, or taken them out of the map.
        if !mapped.starts_with(counted) {
            surface.clear();
            distances.clear();
            counted.clear();
        }
        for frame in &session.frames()[counted.len()..] {
            let points: Vec<DVec3> =
                session.bounds().into_iter().flat_map(|bounds| frame.points_in(bounds)).collect();
            distances.par_extend(points.par_iter().map(|point| truth.surface.distance().at(*point)));
            surface.add(frame);
        }
        *counted = mapped;
        let snapshot = session.map().snapshot(truth.voxels.block());
        record.set_voxels(&truth.voxels.compare(&snapshot, *reachable));
        [record.surface_coverage_1mm, record.surface_coverage_2mm, record.surface_coverage_5mm] =
            surface.shares().map(Some);
        let accuracy = Accuracy::of(distances);
        record.accuracy_mean_mm = accuracy.map(|accuracy| 1e3 * accuracy.mean);
        record.accuracy_median_mm = accuracy.map(|accuracy| 1e3 * accuracy.median);
        record.accuracy_p95_mm = accuracy.map(|accuracy| 1e3 * accuracy.p95);
        surface.within(SEEN).count_ones(..)
    }
}
