//! What a scan hands over: the measured points, thinned, and a surface through them.

use super::FinishedScan;
use crate::Failure;
use nextview::geometry::Lattice;
use nextview::model::{
    CloudPoint, DistanceField, SurfaceMesh, downsample, fit_normals, frame_points, take_colors,
};
use nextview::sensor::ColorImage;
use nextview_sim::run::Step;

/// Cloud and mesh, from the frames in the poses in which they were mapped.
pub(super) struct FinalModel {
    pub cloud: Vec<CloudPoint>,
    pub mesh: SurfaceMesh,
    /// The vertices of the mesh with normals and colours.
    pub vertices: Vec<CloudPoint>,
}

impl FinalModel {
    /// Makes both. Colour images are loaded one after the other.
    pub fn new<M>(
        scan: &FinishedScan<M>,
        color: impl Fn(&Step<M>) -> Result<Option<ColorImage>, Failure>,
    ) -> Result<Self, Failure> {
        let cloud = cloud(scan, color)?;
        let mesh = field(scan)?.surface();
        let mut vertices = mesh.points();
        if cloud.iter().any(|point| point.color.is_some()) {
            take_colors(&mut vertices, &cloud, scan.detail())?;
        }
        Ok(Self { cloud, mesh, vertices })
    }
}

impl<M> FinishedScan<M> {
    /// Size of the cells in which points and mesh are told apart: a quarter of a voxel, since the map's voxels are larger
    /// than what the camera resolves, but no more than 128 along the box, so that the mesh takes a second or two.
    pub(super) fn detail(&self) -> f64 {
        let voxel_size = self.session.map().lattice().voxel_size();
        (0.25 * voxel_size).max(self.bounds.longest_side() / 128.0)
    }

    /// The points of the final cloud without normals and colours, which take most of the time.
    pub(crate) fn plain_cloud(&self) -> Result<Vec<CloudPoint>, Failure> {
        let points = self.steps.iter().flat_map(|step| step.frame.points_in(self.bounds));
        Ok(downsample(points, self.detail())?)
    }
}

fn cloud<M>(
    scan: &FinishedScan<M>,
    color: impl Fn(&Step<M>) -> Result<Option<ColorImage>, Failure>,
) -> Result<Vec<CloudPoint>, Failure> {
    let points_of = |step: &Step<M>| -> Result<Vec<CloudPoint>, Failure> {
        Ok(frame_points(&step.frame, color(step)?.as_ref(), scan.bounds)?)
    };
    let mut loaded = Ok(());
    let points = scan.steps.iter().map_while(|step| {
        points_of(step).map_err(|failure| loaded = Err(failure)).ok() // ends at the first failure
    });
    let mut cloud = downsample(points.flatten(), scan.detail())?;
    fit_normals(&mut cloud, scan.detail())?;
    loaded.map(|()| cloud)
}

fn field<M>(scan: &FinishedScan<M>) -> Result<DistanceField, Failure> {
    let lattice = Lattice::new(scan.detail())?;
    let block = lattice.block_inside(&scan.bounds).expect("the box holds many cells of 1/128 of it");
    let mut field = DistanceField::new(lattice, block, 2.0 * scan.detail())?;
    scan.steps.iter().for_each(|step| field.integrate(&step.frame));
    Ok(field)
}
