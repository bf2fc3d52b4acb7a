use crate::record::SurfaceRecord;
use fixedbitset::FixedBitSet;
use nextview::Cancel;
use nextview::geometry::Pose;
use nextview::sensor::DepthRange;
use nextview_recording::{ReadOptions, Recording};
use nextview_scan::{FRAMES_FOLDER, Fault, ReferenceConfig};
use nextview_sim::inspection::{PlacedPart, SurfaceDemand};
use nextview_sim::mesh::TriangleMesh;
use rayon::prelude::*;
use std::path::Path;

/// The share of each surface of the part that the frames in the results measured as demanded; empty if there
/// are no frames.
pub(crate) fn seen_as_demanded(
    results: &Path,
    reference: &ReferenceConfig,
    mesh: &TriangleMesh,
    world_from_reference: &Pose,
    cancel: &Cancel,
) -> Result<Vec<SurfaceRecord>, Fault> {
    let demands = reference.demands(mesh)?;
    let folder = results.join(FRAMES_FOLDER);
    if !folder.is_dir() {
        return Ok(Vec::new());
    }
    let recording = Recording::open(&folder, &ReadOptions::default())?;
    // Everything a frame measured was within the camera's range.
    let camera = (recording.intrinsics, DepthRange::default());
    let part = PlacedPart::new(mesh, &demands, world_from_reference, camera)?;
    let measured = recording.frames.par_iter().map(|frame| {
        cancel.check()?;
        Ok::<_, Fault>(part.shown_in(&frame.load()?)?.1)
    });
    let none = || Ok(FixedBitSet::with_capacity(demands.samples().len()));
    let measured = measured.try_reduce_with(|mut all, of_frame| {
        all.union_with(&of_frame);
        Ok(all)
    });
    let measured = measured.unwrap_or_else(none)?;
    let of_surface = |(i, demand): (usize, &SurfaceDemand)| {
        let samples = demands.samples().iter().enumerate().filter(|(_, (of, _))| *of == i);
        let is_measured: Vec<bool> = samples.map(|(sample, _)| measured.contains(sample)).collect();
        SurfaceRecord {
            name: demand.name.clone(),
            // As stated: radians are rounded.
            angle_deg: (1e9 * demand.max_angle.to_degrees()).round() / 1e9,
            points_per_mm2: demand.min_density / 1e6,
            measured_share: is_measured.iter().filter(|is| **is).count() as f64 / is_measured.len() as f64,
        }
    };
    Ok(demands.demands().iter().enumerate().map(of_surface).collect())
}
