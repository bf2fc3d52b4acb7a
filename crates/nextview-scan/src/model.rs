//! The final model of a scan: the thinned measured points, and a surface through them.

use crate::{Fault, ModelConfig};
use glam::DVec3;
use nextview::Cancel;
use nextview::geometry::{Aabb, Lattice, Plane};
use nextview::object::{ON_TABLE, TableTops};
use nextview::sensor::{ColorImage, Frame, SurfaceNoise};
use nextview::surface::{CloudPoint, MeasuredCells, frame_points};
use nextview_model::{DistanceField, Floor, SurfaceMesh, WatertightMesh, fused_cloud, take_nearest};

/// Cloud and mesh, from the frames in their mapped poses.
#[derive(Debug)]
pub struct FinalModel {
    /// Measured points in metres with normals, colours if the frames have any, and expected errors if the
    /// camera's error is known.
    pub cloud: Vec<CloudPoint>,
    /// The measured surface.
    pub mesh: SurfaceMesh,
    /// The vertices of the mesh with normals, colours and expected errors.
    pub vertices: Vec<CloudPoint>,
    /// The closed surface with the same vertices; `None` unless configured.
    pub closed: Option<WatertightMesh>,
}

/// The extent and resolution of the model.
#[derive(Clone, Copy)]
pub(crate) struct Extent {
    /// The box in metres.
    pub bounds: Aabb,
    /// The surface below the object.
    pub table: Option<Plane>,
    /// The table in each frame; `None` if frames show only the object.
    pub tops: Option<TableTops>,
    /// Edge of the cells in metres.
    pub detail: f64,
    /// Error of the camera.
    pub error: SurfaceNoise,
}

impl FinalModel {
    /// Builds both from the part of each frame above its table top. Colour images are loaded by number when
    /// needed.
    pub(crate) fn new(
        frames: &[Frame],
        color: impl Fn(usize) -> Result<Option<ColorImage>, Fault>,
        extent: Extent,
        config: ModelConfig,
        cancel: &Cancel,
    ) -> Result<Self, Fault> {
        let Extent { bounds, detail, .. } = extent;
        let tops = extent.tops_in(frames);
        let measured = extent.measured(frames, cancel)?;
        let cloud = cloud(frames, color, &tops, extent, measured.as_ref(), cancel)?;
        drop(measured);
        let field = field(frames, &tops, bounds, detail, cancel)?;
        let floor = extent.floor();
        let closed =
            config.watertight.then(|| field.watertight_surface(floor.as_ref(), cancel)).transpose()?;
        let mesh = closed.as_ref().map_or_else(|| field.surface(cancel), |closed| Ok(closed.measured()))?;
        drop(field); // the largest part of the memory
        let mut vertices = closed.as_ref().map_or(&mesh, |closed| &closed.mesh).points();
        if cloud.iter().any(|point| point.color.is_some() || point.error.is_some()) {
            take_nearest(&mut vertices, &cloud, detail, cancel)?;
        }
        for (vertex, _) in
            vertices.iter_mut().zip(closed.iter().flat_map(|c| &c.is_filled)).filter(|(_, filled)| **filled)
        {
            vertex.error = None;
        }
        Ok(Self { cloud, mesh, vertices, closed })
    }

    /// Median and 95th percentile of the expected errors of the cloud's points in metres; `None` if the
    /// camera's error is unknown.
    pub fn expected_errors(&self) -> Option<[f64; 2]> {
        let mut errors: Vec<f32> = self.cloud.iter().filter_map(|point| point.error).collect();
        errors.sort_by(f32::total_cmp);
        let last = errors.len().checked_sub(1)?;
        Some([0.5, 0.95].map(|share| f64::from(errors[(share * last as f64).round() as usize])))
    }

    /// All triangles, including filled ones.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.closed.as_ref().map_or(&self.mesh, |closed| &closed.mesh).triangles
    }

    /// For each vertex, whether it was filled in; `None` unless the surface is closed.
    pub fn is_filled(&self) -> Option<&[bool]> {
        self.closed.as_ref().map(|closed| closed.is_filled.as_slice())
    }
}

impl Extent {
    /// The table top in each frame.
    fn tops_in(&self, frames: &[Frame]) -> Vec<Option<Plane>> {
        frames.iter().map(|frame| self.tops.map(|tops| tops.in_frame(frame))).collect()
    }

    /// How well the surface was measured; `None` if the camera's error is unknown.
    fn measured(&self, frames: &[Frame], cancel: &Cancel) -> Result<Option<MeasuredCells>, Fault> {
        if self.error == SurfaceNoise::default() {
            return Ok(None);
        }
        let mut measured = MeasuredCells::new(self.detail, self.error)?;
        frames.iter().try_for_each(|frame| measured.add(frame, self.bounds, cancel))?;
        Ok(Some(measured))
    }

    /// The table; everything within reach of its measurements belongs to it.
    fn floor(&self) -> Option<Floor> {
        let clearance = ON_TABLE.max(truncation(self.detail));
        self.table.map(|plane| Floor { plane, clearance })
    }
}

/// The positions of the cloud of a model, if nothing else is needed.
pub(crate) fn cloud_positions(
    frames: &[Frame],
    extent: Extent,
    cancel: &Cancel,
) -> Result<Vec<DVec3>, Fault> {
    let cloud = cloud(frames, |_| Ok(None), &extent.tops_in(frames), extent, None, cancel)?;
    Ok(cloud.iter().map(|point| point.position).collect())
}

/// Truncation distance for cells of this size in metres.
fn truncation(detail: f64) -> f64 {
    2.0 * detail
}

fn cloud(
    frames: &[Frame],
    color: impl Fn(usize) -> Result<Option<ColorImage>, Fault>,
    tops: &[Option<Plane>],
    extent: Extent,
    measured: Option<&MeasuredCells>,
    cancel: &Cancel,
) -> Result<Vec<CloudPoint>, Fault> {
    let mut loaded = Ok(());
    let points = frames.iter().zip(tops).enumerate().map_while(|(i, (frame, top))| {
        let color = cancel.check().map_err(Fault::from).and_then(|()| color(i));
        let points = color.and_then(|color| Ok(frame_points(frame, color, extent.bounds)?));
        let is_above = |point: &CloudPoint| top.is_none_or(|top| top.height(point.position) > 0.0);
        let above = points.map(|points| points.filter(is_above));
        above.map_err(|fault| loaded = Err(fault)).ok() // ends at the first fault
    });
    let cloud = fused_cloud(points.flatten(), extent.detail, measured, cancel);
    loaded?;
    Ok(cloud?)
}

fn field(
    frames: &[Frame],
    tops: &[Option<Plane>],
    bounds: Aabb,
    detail: f64,
    cancel: &Cancel,
) -> Result<DistanceField, Fault> {
    let lattice = Lattice::new(detail)?;
    let block = lattice.block_inside(&bounds).expect("the box holds many cells of 1/128 of it");
    let mut field = DistanceField::new(lattice, block, truncation(detail))?;
    frames.iter().zip(tops).try_for_each(|(frame, top)| field.integrate_above(frame, *top, cancel))?;
    Ok(field)
}
