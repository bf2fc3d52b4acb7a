use crate::scanned::Scanned;
use crate::view::UndistortedView;
use nextview::sensor::Depth;
use nextview_scan::Fault;
use nextview_sim::camera::{Background, SimulatedCamera};
use nextview_sim::mesh::TriangleMesh;
use std::sync::Arc;

/// The pixels that show the object: the final mesh, rendered.
pub(crate) struct Masks {
    camera: SimulatedCamera,
}

/// The object in a picture, pixel by pixel, row by row.
pub(crate) struct Mask {
    /// The object's pixels, including those where something occludes it.
    pub whole: Vec<bool>,
    /// The object's visible pixels: the measured depth agrees with the mesh.
    pub visible: Vec<bool>,
}

/// A pixel belongs to the object if its depth is that of the mesh up to this tolerance: the sum of a length
/// in metres and a share of the depth.
const TOLERANCE: (f64, f64) = (0.005, 0.01);

/// Maximum depth of the rendered mesh, metres.
const RANGE: f64 = 100.0;

impl Masks {
    pub fn new(scanned: &Scanned) -> Result<Self, Fault> {
        let vertices = scanned.object.points.iter().map(|point| point.position).collect();
        let mesh = TriangleMesh::new(vertices, scanned.object.triangles.clone()).map_err(Fault::data)?;
        let camera = SimulatedCamera::new(Arc::new(mesh), scanned.intrinsics, Background::None, RANGE);
        Ok(Self { camera: camera.map_err(Fault::data)? })
    }

    /// The mask of the object in this picture.
    pub fn of(&self, view: &UndistortedView) -> Result<Mask, Fault> {
        let rendered = self.camera.render_depth(&view.world_from_camera())?;
        let whole: Vec<bool> = rendered.iter().map(|depth| depth.is_finite()).collect();
        let visible = rendered
            .iter()
            .zip(view.frame.image().pixels())
            .map(|(depth, pixel)| is_seen(f64::from(*depth), pixel));
        Ok(Mask { whole, visible: visible.collect() })
    }
}

fn is_seen(rendered: f64, measured: Depth) -> bool {
    match measured {
        _ if !rendered.is_finite() => false,
        Depth::Missing => true,
        Depth::Beyond => false,
        Depth::Surface(depth) => (f64::from(depth) - rendered).abs() <= TOLERANCE.0 + TOLERANCE.1 * rendered,
    }
}
