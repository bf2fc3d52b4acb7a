use super::reachable::ReachableSurface;
use super::scores::{Completeness, Quality, TOLERANCES, share_within};
use crate::accuracy::{Accuracy, SurfaceDistance};
use crate::mesh::{TriangleMesh, surface_samples};
use glam::DVec3;
use nextview_model::SurfaceMesh;
use rayon::prelude::*;

/// Maximum number of model points measured: an even selection gives mean and quantiles to a hundredth of
/// their spread. With wrong poses, a cloud has many points far from the surface, which take long.
const N_POINTS: usize = 20_000;

/// The surface against which models are evaluated.
///
/// ```
/// use glam::DVec3;
/// use nextview_sim::mesh::TriangleMesh;
/// use nextview_sim::quality::TrueSurface;
///
/// // A square of a metre, and one point a millimetre above its middle.
/// let corners = vec![DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y];
/// let square = TriangleMesh::new(corners, vec![[0, 1, 2], [0, 2, 3]]).unwrap();
/// let quality = TrueSurface::new(&square).of_points(&[DVec3::new(0.5, 0.5, 0.001)], None).unwrap();
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
    /// Creates the surface of a mesh, in the world of the models.
    pub fn new(mesh: &TriangleMesh) -> Self {
        Self { distance: SurfaceDistance::new(mesh), samples: surface_samples(mesh) }
    }

    /// Returns the surface, for the distance of any point.
    pub fn distance(&self) -> &SurfaceDistance {
        &self.distance
    }

    /// Returns the samples for completeness, uniform by area.
    pub fn samples(&self) -> &[DVec3] {
        &self.samples
    }

    /// Returns the quality of a cloud of finite points; `None` if there are no points.
    pub fn of_points(&self, points: &[DVec3], reachable: Option<&ReachableSurface>) -> Option<Quality> {
        self.quality(points, &SurfaceDistance::to_points(points)?, reachable)
    }

    /// Returns the quality of a mesh of finite vertices, whose points are the vertices of its triangles.
    /// `None` if there are no triangles of positive size.
    pub fn of_mesh(&self, mesh: &SurfaceMesh, reachable: Option<&ReachableSurface>) -> Option<Quality> {
        let model = TriangleMesh::new(mesh.vertices.clone(), mesh.triangles.clone()).ok()?;
        let mut is_used = vec![false; mesh.vertices.len()];
        mesh.triangles.iter().flatten().for_each(|&i| is_used[i as usize] = true);
        let used = mesh.vertices.iter().zip(is_used).filter(|(_, is_used)| *is_used);
        let vertices: Vec<DVec3> = used.map(|(vertex, _)| *vertex).collect();
        self.quality(&vertices, &SurfaceDistance::new(&model), reachable)
    }

    /// The quality of a model with these points and this surface; `None` if there are no points.
    fn quality(
        &self,
        points: &[DVec3],
        model: &SurfaceDistance,
        reachable: Option<&ReachableSurface>,
    ) -> Option<Quality> {
        let away = distances(&self.distance, &evenly(points, N_POINTS));
        let missing = distances(model, &self.samples);
        let of_reachable = |part: &ReachableSurface| {
            let missing = missing.iter().enumerate().filter(|(sample, _)| part.contains(*sample));
            Completeness::of(&missing.map(|(_, distance)| *distance).collect::<Vec<_>>())
        };
        Some(Quality {
            accuracy: Accuracy::of(&away)?,
            precision: TOLERANCES.map(|limit| share_within(&away, limit)),
            completeness: Completeness::of(&missing)?,
            reachable: reachable.and_then(of_reachable),
        })
    }
}

/// At most `n` of the points, every second, third, … of them.
pub(super) fn evenly(points: &[DVec3], n: usize) -> Vec<DVec3> {
    points.iter().copied().step_by(points.len().div_ceil(n).max(1)).collect()
}

pub(super) fn distances(to: &SurfaceDistance, from: &[DVec3]) -> Vec<f64> {
    from.par_iter().map(|point| to.at(*point)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builtin;
    use nextview::geometry::{Aabb, Lattice};
    use nextview_model::surface_nets;

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
        let whole = surface.of_points(&sheet(0.0, 1.0), None).unwrap();
        assert!(whole.accuracy.p95 < 1e-12 && whole.completeness.within == [1.0; 3]);
        assert!(whole.completeness.mean < 0.0005, "half a millimetre from the grid, at most 0.71");

        let half = surface.of_points(&sheet(0.0015, 0.0), None).unwrap();
        let Accuracy { mean, median, p95 } = half.accuracy;
        assert!([mean, median, p95].iter().all(|distance| (distance - 0.0015).abs() < 1e-12));
        let [within_1, within_2, within_5] = half.completeness.within;
        assert_eq!(within_1, 0.0);
        assert!((within_2 - 0.5).abs() < 0.03 && (within_5 - 0.52).abs() < 0.03, "{within_2} {within_5}");
        // Half of the samples are 1.6 mm away, the others 50 mm on average.
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
        let same = surface.of_mesh(&truth, None).unwrap();
        assert!(same.accuracy.p95 < 1e-12 && same.completeness.mean < 1e-12);
        assert_eq!(same.completeness.within, [1.0; 3]);
        let larger = surface.of_mesh(&ball(0.103), None).unwrap();
        assert!((larger.accuracy.mean - 0.003).abs() < 1e-4, "{:?}", larger.accuracy);
        assert!((larger.completeness.mean - 0.003).abs() < 1e-4, "{:?}", larger.completeness);
        assert_eq!((larger.completeness.within[1], larger.completeness.within[2]), (0.0, 1.0));

        let mut loose = truth;
        loose.vertices.push(DVec3::ONE);
        assert_eq!(surface.of_mesh(&loose, None), Some(same), "a vertex of no triangle does not count");
    }

    /// Half of the square is reachable and fully seen; the other half counts in the completeness only.
    #[test]
    fn what_no_view_reaches_is_not_missed() {
        let surface = TrueSurface::new(&square());
        let half = ReachableSurface::of(surface.samples().iter().map(|sample| sample.x <= 0.0));
        let quality = surface.of_points(&sheet(0.0, 0.0), Some(&half)).unwrap();
        assert_eq!((quality.recall(), quality.f_score()), (Some([1.0; 3]), Some([1.0; 3])));
        assert!((quality.completeness.within[0] - 0.5).abs() < 0.03 && quality.chamfer().unwrap() < 0.0005);

        // Half of a cloud is 3 mm off: precision one half at 1 and 2 mm, for every third of its points.
        let mut cloud = sheet(0.0, 0.0);
        cloud.extend(sheet(0.003, 0.0));
        let quality = surface.of_points(&cloud, Some(&half)).unwrap();
        assert_eq!((quality.precision[2], quality.recall()), (1.0, Some([1.0; 3])));
        assert!((quality.precision[1] - 0.5).abs() < 1e-3, "{:?}", quality.precision);
        assert!((quality.f_score().unwrap()[1] - 2.0 / 3.0).abs() < 1e-3);
        let expected = 0.5 * (quality.accuracy.mean + quality.reachable.unwrap().mean);
        assert_eq!(quality.chamfer(), Some(expected));

        let nothing = ReachableSurface::of(surface.samples().iter().map(|_| false));
        let unknown = surface.of_points(&cloud, Some(&nothing)).unwrap();
        assert_eq!((unknown.reachable, unknown.f_score(), unknown.chamfer()), (None, None, None));
    }

    #[test]
    fn nothing_has_no_quality() {
        let surface = TrueSurface::new(&builtin::by_name("mug").unwrap());
        assert_eq!(
            (surface.of_points(&[], None), surface.of_mesh(&SurfaceMesh::default(), None)),
            (None, None)
        );
    }
}
