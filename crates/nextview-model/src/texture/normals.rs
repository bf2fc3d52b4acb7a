use glam::DVec3;

/// Number of smoothing rounds: triangles of a noisy surface face anywhere.
const N_ROUNDS: usize = 3;

/// Returns the outward unit normal of every triangle, averaged with those around it; zero if it is undefined.
/// The corners of a triangle run counter-clockwise seen from outside.
pub(super) fn smooth(vertices: &[DVec3], triangles: &[[u32; 3]]) -> Vec<DVec3> {
    let area = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|i| vertices[i as usize]);
        (b - a).cross(c - a)
    };
    let areas: Vec<DVec3> = triangles.iter().map(area).collect();
    let mut normals: Vec<DVec3> = areas.iter().map(|area| area.normalize_or_zero()).collect();
    for _ in 0..N_ROUNDS {
        let mut sums = vec![DVec3::ZERO; vertices.len()];
        for ((triangle, area), normal) in triangles.iter().zip(&areas).zip(&normals) {
            triangle.iter().for_each(|i| sums[*i as usize] += area.length() * *normal);
        }
        let around = |triangle: &[u32; 3]| triangle.map(|i| sums[i as usize].normalize_or_zero());
        normals =
            triangles.iter().map(|t| around(t).into_iter().sum::<DVec3>().normalize_or_zero()).collect();
    }
    normals
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_crumpled_plane_faces_up() {
        let n = 12;
        let height = |i: usize, j: usize| 0.6 * ((7 * i + 5 * j) % 3) as f64;
        let at = |k: usize| DVec3::new((k / n) as f64, (k % n) as f64, height(k / n, k % n));
        let vertices: Vec<DVec3> = (0..n * n).map(at).collect();
        let corner = |i: usize, j: usize| (i * n + j) as u32;
        let squares = (0..n - 1).flat_map(|i| (0..n - 1).map(move |j| (i, j)));
        let triangles: Vec<[u32; 3]> = squares
            .flat_map(|(i, j)| {
                let [a, b] = [corner(i, j), corner(i + 1, j)];
                [[a, b, b + 1], [a, b + 1, a + 1]]
            })
            .collect();
        let flat = |normal: &DVec3| normal.z > 0.95;
        assert!(smooth(&vertices, &triangles).iter().filter(|normal| flat(normal)).count() > 150);
        assert_eq!(smooth(&[DVec3::ZERO], &[[0, 0, 0]]), [DVec3::ZERO]);
    }
}
