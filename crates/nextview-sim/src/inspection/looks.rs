use super::SurfaceDemands;
use crate::SimError;
use crate::camera::{Background, SimulatedCamera};
use crate::mesh::TriangleMesh;
use fixedbitset::FixedBitSet;
use nextview::Error;
use nextview::geometry::Pose;
use nextview::registration::SurfacePoint;
use nextview::sensor::{DepthRange, Frame, Intrinsics};

/// A part at its pose before a camera: determines the samples of its surfaces that a picture shows as
/// demanded.
pub struct PlacedPart<'a> {
    demands: &'a SurfaceDemands,
    /// The samples in the world.
    samples: Vec<SurfacePoint>,
    /// Camera that looks at the part's model.
    camera: SimulatedCamera,
    range: DepthRange,
    /// Maximum distance of the part's readings from the model, metres.
    near: f64,
}

/// A sample is shown if its pixel shows the model within this distance, metres.
const SHOWN: f64 = 0.002;

/// Readings within this share of the model's diagonal belong to the part, defects included.
const NEAR: f64 = 0.05;

impl<'a> PlacedPart<'a> {
    /// Places the CAD model `mesh` before a camera with these optics and depths.
    pub fn new(
        mesh: &TriangleMesh,
        demands: &'a SurfaceDemands,
        world_from_reference: &Pose,
        (intrinsics, range): (Intrinsics, DepthRange),
    ) -> Result<Self, SimError> {
        let placed = mesh.transformed(world_from_reference)?;
        let near = NEAR * mesh.bounds().size().length();
        let camera = SimulatedCamera::new(placed.into(), intrinsics, Background::None, range.max)?;
        let samples =
            demands.samples().iter().map(|(_, sample)| sample.moved(world_from_reference)).collect();
        Ok(Self { demands, samples, camera, range, near })
    }

    /// Returns the samples that a picture from this pose would show as demanded.
    pub fn shown_from(&self, world_from_camera: &Pose) -> Result<FixedBitSet, Error> {
        let camera_from_world = world_from_camera.inverse();
        let look = self.camera.look(world_from_camera)?;
        let is_shown = |sample: &usize| {
            let (demand, point) = (self.demands.samples()[*sample].0, &self.samples[*sample]);
            let in_camera = point.moved(&camera_from_world);
            (self.range.min..=self.range.max).contains(&in_camera.position.z)
                && self.demands.demands()[demand].is_met(&in_camera, self.camera.intrinsics())
                && look.shows(point.position, SHOWN)
        };
        let mut shown = FixedBitSet::with_capacity(self.samples.len());
        shown.extend((0..self.samples.len()).filter(is_shown));
        Ok(shown)
    }

    /// Returns the samples that a frame should have shown as demanded, and those it measured.
    pub fn shown_in(&self, frame: &Frame) -> Result<(FixedBitSet, FixedBitSet), Error> {
        let shown = self.shown_from(&frame.world_from_camera())?;
        let camera_from_world = frame.world_from_camera().inverse();
        let is_measured = |sample: &usize| {
            let point = camera_from_world.transform_point(self.samples[*sample].position);
            let pixel = frame.intrinsics().project(point).filter(|pixel| frame.intrinsics().contains(*pixel));
            let reading =
                pixel.map(|pixel| frame.image().get(pixel.x.round() as u32, pixel.y.round() as u32));
            let depth = reading.map_or(f64::NAN, |reading| f64::from(reading.metres()));
            (depth - point.z).abs() * point.length() <= self.near * point.z
        };
        let mut measured = FixedBitSet::with_capacity(self.samples.len());
        measured.extend(shown.ones().filter(is_measured));
        Ok((shown, measured))
    }
}
