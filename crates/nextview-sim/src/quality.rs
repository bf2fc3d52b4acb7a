//! The quality of the model that a scan produces: accuracy and completeness against the true surface.

use crate::accuracy::{Accuracy, SurfaceDistance};
use crate::mesh::{TriangleMesh, sample_surface};
use crate::truth::SEED;
use glam::DVec3;
use nextview::surface::SurfaceMesh;
use rayon::prelude::*;

/// Number of samples of the true surface: the standard error of a share is then at most 0.5 %.
const N_SAMPLES: usize = 10_000;

/// Maximum number of model points whose distance from the surface is measured: an even selection gives mean
/// and quantiles to a hundredth of their spread. Where poses are wrong, a cloud has many points far from the
/// surface, which take long.
const N_POINTS: usize = 20_000;

/// Accuracy and completeness of a model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quality {
    /// From the model's points to the true surface.
    pub accuracy: Accuracy,
    /// From the true surface to the model.
    pub completeness: Completeness,
}

/// How far samples of the true surface, uniform by area, are from a model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Completeness {
    /// Share, 0..=1, of those that are at most 1, 2 and 5 mm away.
    pub within: [f64; 3],
    /// Mean distance, metres.
    pub mean: f64,
}

/// The surface that models are measured against.
///
/// ```
/// use glam::DVec3;
/// use nextview_sim::mesh::TriangleMesh;
/// use nextview_sim::quality::TrueSurface;
///
/// // A square of a metre, and one point a millimetre above its middle.
/// let corners = vec![DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y];
/// let square = TriangleMesh::new(corners, vec![[0, 1, 2], [0, 2, 3]]).unwrap();
/// let quality = TrueSurface::new(&square).of_points(&[DVec3::new(0.5, 0.5, 0.001)]).unwrap();
/// assert!((quality.accuracy.mean - 0.001).abs() < 1e-12);
/// assert!(quality.completeness.within[2] < 0.001);
/// assert!((quality.completeness.mean - 0.3826).abs() < 0.005, "the mean distance from the middle of a square");
/// ```
#[derive(Clone, Debug)]
pub struct TrueSurface {
    distance: SurfaceDistance,
    samples: Vec<DVec3>,
}

impl TrueSurface {
    /// The surface of a mesh, in the world of the models.
    pub fn new(mesh: &TriangleMesh) -> Self {
        Self { distance: SurfaceDistance::new(mesh), samples: sample_surface(mesh, N_SAMPLES, SEED) }
    }

    /// The distance of any point from the surface.
    pub fn distance(&self) -> &SurfaceDistance {
        &self.distance
    }

    /// The quality of a cloud of finite points; none without points.
    pub fn of_points(&self, points: &[DVec3]) -> Option<Quality> {
        Some(self.quality(points, &SurfaceDistance::to_points(points)?))
    }

    /// The quality of a mesh of finite vertices: the accuracy is that of the vertices of its triangles. None
    /// without triangles of a size.
    pub fn of_mesh(&self, mesh: &SurfaceMesh) -> Option<Quality> {
        let model = TriangleMesh::new(mesh.vertices.clone(), mesh.triangles.clone()).ok()?;
        let mut is_used = vec![false; mesh.vertices.len()];
        mesh.triangles.iter().flatten().for_each(|&i| is_used[i as usize] = true);
        let used = mesh.vertices.iter().zip(is_used).filter(|(_, is_used)| *is_used);
        let vertices: Vec<DVec3> = used.map(|(vertex, _)| *vertex).collect();
        Some(self.quality(&vertices, &SurfaceDistance::new(&model)))
    }

    /// The quality of a model with these points (at least one) and this surface.
    fn quality(&self, points: &[DVec3], model: &SurfaceDistance) -> Quality {
        let every = points.len().div_ceil(N_POINTS);
        let some: Vec<DVec3> = points.iter().copied().step_by(every).collect();
        let accuracy = Accuracy::of(&distances(&self.distance, &some)).expect("the model has points");
        let missing = distances(model, &self.samples);
        let share = |limit: f64| missing.iter().filter(|d| **d <= limit).count() as f64 / N_SAMPLES as f64;
        let mean = missing.iter().sum::<f64>() / N_SAMPLES as f64;
        Quality { accuracy, completeness: Completeness { within: [0.001, 0.002, 0.005].map(share), mean } }
    }
}

fn distances(to: &SurfaceDistance, from: &[DVec3]) -> Vec<f64> {
    from.par_iter().map(|point| to.at(*point)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builtin;
    use nextview::geometry::{Aabb, Lattice};
    use nextview::surface::surface_nets;

    /// A square of 0.2 m in the plane z = 0.
    fn square() -> TriangleMesh {
        let corners =
            [(-0.1, -0.1), (0.1, -0.1), (0.1, 0.1), (-0.1, 0.1)].map(|(x, y)| DVec3::new(x, y, 0.0));
        TriangleMesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]]).unwrap()
    }

    /// A grid of points a millimetre apart, at this height above the part of the square up to `end` along x.
    fn sheet(height: f64, end: f64) -> Vec<DVec3> {
        let steps = || (0..=200).map(|i| -0.1 + 0.001 * i as f64);
        steps().filter(|x| *x <= end).flat_map(|x| steps().map(move |y| DVec3::new(x, y, height))).collect()
    }

    #[test]
    fn an_offset_is_the_accuracy_and_a_hole_the_completeness() {
        let surface = TrueSurface::new(&square());
        let whole = surface.of_points(&sheet(0.0, 1.0)).unwrap();
        assert!(whole.accuracy.p95 < 1e-12 && whole.completeness.within == [1.0; 3]);
        assert!(whole.completeness.mean < 0.0005, "half a millimetre from the grid, at most 0.71");

        let half = surface.of_points(&sheet(0.0015, 0.0)).unwrap();
        let Accuracy { mean, median, p95 } = half.accuracy;
        assert!([mean, median, p95].iter().all(|distance| (distance - 0.0015).abs() < 1e-12));
        let [within_1, within_2, within_5] = half.completeness.within;
        assert_eq!(within_1, 0.0);
        assert!((within_2 - 0.5).abs() < 0.03 && (within_5 - 0.52).abs() < 0.03, "{within_2} {within_5}");
        // Half of the samples 1.6 mm away, the others 50 mm in the mean.
        assert!((half.completeness.mean - 0.026).abs() < 0.001, "{}", half.completeness.mean);
    }

    #[test]
    fn a_meshed_ball_of_another_size_is_off_by_the_difference() {
        let lattice = Lattice::new(0.004).unwrap();
        let block = lattice.block_inside(&Aabb::cube(DVec3::ZERO, 0.13)).unwrap();
        let ball = |radius: f64| {
            surface_nets(&lattice, &block, |i| Some(lattice.center(block.key(i)).length() - radius))
        };
        let truth = ball(0.1);
        let surface =
            TrueSurface::new(&TriangleMesh::new(truth.vertices.clone(), truth.triangles.clone()).unwrap());
        let same = surface.of_mesh(&truth).unwrap();
        assert!(same.accuracy.p95 < 1e-12 && same.completeness.mean < 1e-12);
        assert_eq!(same.completeness.within, [1.0; 3]);
        let larger = surface.of_mesh(&ball(0.103)).unwrap();
        assert!((larger.accuracy.mean - 0.003).abs() < 1e-4, "{:?}", larger.accuracy);
        assert!((larger.completeness.mean - 0.003).abs() < 1e-4, "{:?}", larger.completeness);
        assert_eq!((larger.completeness.within[1], larger.completeness.within[2]), (0.0, 1.0));

        let mut loose = truth;
        loose.vertices.push(DVec3::ONE);
        assert_eq!(surface.of_mesh(&loose), Some(same), "a vertex of no triangle does not count");
    }

    #[test]
    fn nothing_has_no_quality() {
        let surface = TrueSurface::new(&builtin::by_name("mug").unwrap());
        assert_eq!((surface.of_points(&[]), surface.of_mesh(&SurfaceMesh::default())), (None, None));
    }
}
