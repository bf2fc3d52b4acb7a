use crate::SimError;
use crate::accuracy::SurfaceDistance;
use crate::mesh::{TriangleMesh, sample_surface};
use glam::DVec3;
use nextview::Error;
use nextview::geometry::Aabb;
use nextview::registration::SurfacePoint;
use nextview::sensor::Intrinsics;
use rayon::prelude::*;
use std::f64::consts::FRAC_PI_2;

/// A requirement on a surface of a part: all of it in good enough pictures, each point in one.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceDemand {
    /// The surface's name.
    pub name: String,
    /// The box, in the CAD model's coordinates and metres, that holds the surface; `None` for all of the
    /// model.
    pub bounds: Option<Aabb>,
    /// Largest angle between the line of sight and the surface's normal, radians, above 0 and below a right
    /// angle.
    pub max_angle: f64,
    /// Minimum number of pixels per square metre of the surface, at least 0.
    pub min_density: f64,
}

/// The demanded surfaces of a part, as samples.
#[derive(Clone, Debug)]
pub struct SurfaceDemands {
    demands: Vec<SurfaceDemand>,
    /// The samples, each with the number of its demand, in the coordinates of the CAD model.
    samples: Vec<(usize, SurfacePoint)>,
}

/// Samples of the whole model, uniform by area.
const N_DRAWN: usize = 100_000;

/// Maximum number of samples per demand: the standard error of a share of them is at most 1.1 %.
const N_SAMPLES: usize = 2_000;

/// Minimum number of samples of a surface: fewer do not represent its parts.
const FEWEST: usize = 10;

impl SurfaceDemands {
    /// Samples a CAD model in metres whose triangles run counter-clockwise seen from outside.
    ///
    /// # Errors
    /// If a number is out of range, or if hardly any of the model lies in the box of a demand.
    pub fn new(mesh: &TriangleMesh, demands: Vec<SurfaceDemand>) -> Result<Self, SimError> {
        let drawn = sample_surface(mesh, N_DRAWN, 0);
        let surface = SurfaceDistance::new(mesh);
        let mut samples = Vec::new();
        for (i, demand) in demands.iter().enumerate() {
            demand.faults().into_iter().next().map_or(Ok(()), Err)?;
            let is_in = |point: &&DVec3| demand.bounds.is_none_or(|bounds| bounds.contains(**point));
            let inside: Vec<&DVec3> = drawn.iter().filter(is_in).collect();
            if inside.len() < FEWEST {
                return Err(SimError::parameter(
                    "surface",
                    &demand.name,
                    "a box that holds more of the model's surface; its corners are in the model's coordinates",
                ));
            }
            let step = inside.len().div_ceil(N_SAMPLES);
            let chosen: Vec<DVec3> = inside.into_iter().step_by(step).copied().collect();
            let with_normal = |position: DVec3| SurfacePoint { position, normal: surface.foot(position).1 };
            let of_demand: Vec<SurfacePoint> = chosen.into_par_iter().map(with_normal).collect();
            samples.extend(of_demand.into_iter().map(|sample| (i, sample)));
        }
        Ok(Self { demands, samples })
    }

    /// Returns the demands.
    pub fn demands(&self) -> &[SurfaceDemand] {
        &self.demands
    }

    /// Returns the samples, each with the number of its demand, in the coordinates of the CAD model, uniform
    /// by area over each surface.
    pub fn samples(&self) -> &[(usize, SurfacePoint)] {
        &self.samples
    }
}

impl SurfaceDemand {
    /// Returns all out-of-range numbers.
    pub fn faults(&self) -> Vec<Error> {
        let Self { max_angle, min_density, .. } = *self;
        let fault =
            |name, value: f64, expected| Error::InvalidParameter { name, value: value.to_string(), expected };
        let mut faults = Vec::new();
        if !(max_angle > 0.0 && max_angle < FRAC_PI_2) {
            let expected = "an angle above 0 and below 90 degrees";
            faults.push(fault("angle_deg", max_angle.to_degrees(), expected));
        }
        if !(min_density >= 0.0 && min_density.is_finite()) {
            faults.push(fault("points_per_mm2", min_density / 1e6, "a finite number, at least 0"));
        }
        faults
    }

    /// Whether a picture that shows this point, in the coordinates of its camera, is good enough.
    pub(super) fn is_met(&self, point_in_camera: &SurfacePoint, intrinsics: &Intrinsics) -> bool {
        let SurfacePoint { position, normal } = *point_in_camera;
        let distance = position.length();
        let cosine = -normal.dot(position) / distance;
        // A pixel's cone meets z^2 cos(a) / (f^2 cos(t)) of a surface at the depth z, a off the axis of the
        // camera and t off the surface's normal.
        let focal = intrinsics.focal();
        let density = focal.x * focal.y * cosine * distance / position.z.powi(3);
        cosine >= self.max_angle.cos() && density >= self.min_density
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builtin;
    use glam::DVec2;

    fn demand(max_angle: f64, min_density: f64) -> SurfaceDemand {
        SurfaceDemand { name: "all".to_owned(), bounds: None, max_angle, min_density }
    }

    fn point(position: DVec3, normal: DVec3) -> SurfacePoint {
        SurfacePoint { position, normal: normal.normalize() }
    }

    /// The density is that of the pixels whose rays meet a small square, counted one by one.
    #[test]
    fn density_is_the_number_of_pixels_on_a_square_metre() {
        let intrinsics = Intrinsics::pinhole(2000, 2000, DVec2::splat(4000.0), DVec2::splat(999.5)).unwrap();
        let shown = point(DVec3::new(0.06, -0.04, 0.5), DVec3::new(0.3, 0.5, -1.0));
        let (u, half) = (shown.normal.any_orthonormal_vector(), 0.005);
        let v = shown.normal.cross(u);
        let mut n = 0;
        for (row, column) in (0..2000).flat_map(|row| (0..2000).map(move |column| (row, column))) {
            let ray = intrinsics.deproject(DVec2::new(column as f64, row as f64)).unwrap().extend(1.0);
            let met = ray * (shown.normal.dot(shown.position) / shown.normal.dot(ray)) - shown.position;
            n += usize::from(met.dot(u).abs() < half && met.dot(v).abs() < half);
        }
        let counted = n as f64 / (2.0 * half).powi(2);
        assert!(demand(1.5, 0.99 * counted).is_met(&shown, &intrinsics), "{counted}");
        assert!(!demand(1.5, 1.01 * counted).is_met(&shown, &intrinsics), "{counted}");
    }

    #[test]
    fn the_angle_is_that_to_the_line_of_sight() {
        let intrinsics = Intrinsics::d435i();
        let shown = point(DVec3::new(0.1, 0.0, 0.1), DVec3::NEG_Z);
        assert!(
            demand(0.8, 0.0).is_met(&shown, &intrinsics) && !demand(0.78, 0.0).is_met(&shown, &intrinsics)
        );
        let away = point(DVec3::Z, DVec3::Z);
        assert!(!demand(1.5, 0.0).is_met(&away, &intrinsics), "it is seen from behind");
    }

    #[test]
    fn samples_are_those_of_the_box() {
        let mesh = builtin::by_name("mug").unwrap();
        let bounds = mesh.bounds();
        let upper = Aabb { min: bounds.center().with_x(bounds.min.x).with_y(bounds.min.y), max: bounds.max };
        let demands = vec![demand(1.0, 0.0), SurfaceDemand { bounds: Some(upper), ..demand(0.5, 0.0) }];
        let sampled = SurfaceDemands::new(&mesh, demands).unwrap();
        let of = |i: usize| sampled.samples().iter().filter(move |(demand, _)| *demand == i);
        assert!(of(0).count() > 1000 && of(1).count() > 1000);
        assert!(of(1).all(|(_, sample)| upper.contains(sample.position)));
        assert!(of(0).any(|(_, sample)| !upper.contains(sample.position)));
    }

    #[test]
    fn refuses_what_cannot_be_met() {
        let mesh = builtin::by_name("mug").unwrap();
        let refusal = |demand| SurfaceDemands::new(&mesh, vec![demand]).unwrap_err().to_string();
        let elsewhere = Some(Aabb::cube(DVec3::splat(9.0), 0.1));
        assert!(refusal(SurfaceDemand { bounds: elsewhere, ..demand(1.0, 0.0) }).contains("surface"));
        assert!(refusal(demand(0.0, 0.0)).contains("angle_deg"));
        assert!(refusal(demand(1.6, 0.0)).contains("below 90"));
        assert!(refusal(demand(1.0, f64::NAN)).contains("points_per_mm2"));
    }
}
