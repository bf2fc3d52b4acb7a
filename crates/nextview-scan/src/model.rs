//! The final model of a scan: the measured points, thinned, and a surface through them.

use crate::Fault;
use nextview::Cancel;
use nextview::geometry::{Aabb, Lattice};
use nextview::sensor::{ColorImage, Frame};
use nextview::surface::{
    CloudPoint, DistanceField, SurfaceMesh, downsample, fit_normals, frame_points, take_colors,
};

/// Cloud and mesh, from the frames in the poses in which they were mapped.
#[derive(Debug)]
pub struct FinalModel {
    /// Measured points, metres, with normals and, where frames have it, colour.
    pub cloud: Vec<CloudPoint>,
    /// The surface.
    pub mesh: SurfaceMesh,
    /// The vertices of the mesh with normals and colours.
    pub vertices: Vec<CloudPoint>,
}

impl FinalModel {
    /// Makes both from frames in this box, in cells of this size, metres. The colour image of each frame is
    /// loaded by its number when it is needed.
    pub(crate) fn new(
        frames: &[Frame],
        color: impl Fn(usize) -> Result<Option<ColorImage>, Fault>,
        bounds: Aabb,
        detail: f64,
        cancel: &Cancel,
    ) -> Result<Self, Fault> {
        let cloud = cloud(frames, color, bounds, detail, cancel)?;
        let mesh = field(frames, bounds, detail, cancel)?.surface(cancel)?;
        let mut vertices = mesh.points();
        if cloud.iter().any(|point| point.color.is_some()) {
            take_colors(&mut vertices, &cloud, detail, cancel)?;
        }
        Ok(Self { cloud, mesh, vertices })
    }
}

fn cloud(
    frames: &[Frame],
    color: impl Fn(usize) -> Result<Option<ColorImage>, Fault>,
    bounds: Aabb,
    detail: f64,
    cancel: &Cancel,
) -> Result<Vec<CloudPoint>, Fault> {
    let mut loaded = Ok(());
    let points = frames.iter().enumerate().map_while(|(i, frame)| {
        let color = cancel.check().map_err(Fault::from).and_then(|()| color(i));
        let points = color.and_then(|color| Ok(frame_points(frame, color, bounds)?));
        points.map_err(|fault| loaded = Err(fault)).ok() // ends at the first fault
    });
    let mut cloud = downsample(points.flatten(), detail)?;
    loaded?;
    fit_normals(&mut cloud, detail, cancel)?;
    Ok(cloud)
}

fn field(frames: &[Frame], bounds: Aabb, detail: f64, cancel: &Cancel) -> Result<DistanceField, Fault> {
    let lattice = Lattice::new(detail)?;
    let block = lattice.block_inside(&bounds).expect("the box holds many cells of 1/128 of it");
    let mut field = DistanceField::new(lattice, block, 2.0 * detail)?;
    frames.iter().try_for_each(|frame| field.integrate(frame, cancel))?;
    Ok(field)
}
