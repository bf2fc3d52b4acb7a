use super::TriangleMesh;
use super::triangle_mesh::area;
use glam::DVec3;
use nextview::geometry::random::Random;

/// Number of samples for surface distances: the standard error of a share of them is at most 0.5 %.
pub(crate) const N_SAMPLES: usize = 10_000;

/// The samples shared by all measures, uniform by area, identical in every scan.
pub(crate) fn surface_samples(mesh: &TriangleMesh) -> Vec<DVec3> {
    sample_surface(mesh, N_SAMPLES, 0)
}

/// Returns `n` random points of the surface in metres, uniform by area. The same seed gives the same points.
pub fn sample_surface(mesh: &TriangleMesh, n: usize, seed: u64) -> Vec<DVec3> {
    let cumulative: Vec<f64> = (0..mesh.triangles().len())
        .scan(0.0, |sum, i| {
            *sum += area(mesh.corners(i));
            Some(*sum)
        })
        .collect();
    let total = cumulative[cumulative.len() - 1];
    let mut random = Random::new(seed, 0);
    (0..n)
        .map(|_| {
            let drawn = random.unit() * total;
            let triangle = cumulative.partition_point(|&sum| sum <= drawn).min(cumulative.len() - 1);
            point_in(mesh.corners(triangle), &mut random)
        })
        .collect()
}

/// A point of a triangle, uniform by area (Osada et al. 2002, eq. 1).
fn point_in([a, b, c]: [DVec3; 3], random: &mut Random) -> DVec3 {
    let (row, along) = (random.unit().sqrt(), random.unit());
    a + row * (1.0 - along) * (b - a) + row * along * (c - a)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_lie_on_the_surface_in_proportion_to_area() {
        let vertices =
            vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z, DVec3::new(3.0, 0.0, 1.0), DVec3::Y + DVec3::Z];
        let mesh = TriangleMesh::new(vertices, vec![[0, 1, 2], [3, 4, 5]]).unwrap();
        let points = sample_surface(&mesh, 10_000, 7);
        let upper = points.iter().filter(|p| p.z == 1.0).count();
        assert_eq!(upper + points.iter().filter(|p| p.z == 0.0).count(), 10_000);
        assert!((7300..7700).contains(&upper), "the upper triangle has three quarters of the area: {upper}");
        let mean = points.iter().filter(|p| p.z == 0.0).sum::<DVec3>() / (10_000 - upper) as f64;
        assert!(mean.distance(DVec3::new(1.0 / 3.0, 1.0 / 3.0, 0.0)) < 0.02, "{mean}");
        assert_eq!(points, sample_surface(&mesh, 10_000, 7));
        assert_ne!(points, sample_surface(&mesh, 10_000, 8));
    }
}
