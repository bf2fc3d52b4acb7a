use super::SurfaceMesh;
use glam::DVec3;

/// Share of the largest part's area above which a part is never a speck.
const LARGEST_SHARE: f64 = 0.01;

/// Number of triangles below which a small part is always a speck: it is less than three cells wide.
const LEAST_TRIANGLES: usize = 100;

/// Minimum evidence for a small part to be kept, in frames that look from the front.
const LEAST_EVIDENCE: f64 = 2.0;

/// A part of a mesh that is connected to nothing else.
#[derive(Clone, Copy, Debug, Default)]
struct MeshPart {
    area: f64,
    n_triangles: usize,
    /// Sum of the evidence at the corners of its triangles.
    evidence: f64,
}

/// Returns a mesh without its specks and unused vertices. `evidence` is the weighted number of frames that
/// measured the surface at a point.
pub(super) fn without_specks(mesh: SurfaceMesh, evidence: impl Fn(DVec3) -> f32) -> SurfaceMesh {
    let kept = kept_vertices(&mesh, evidence);
    only(mesh, &kept)
}

/// Returns, by vertex, whether it belongs to a triangle outside specks.
pub(super) fn kept_vertices(mesh: &SurfaceMesh, evidence: impl Fn(DVec3) -> f32) -> Vec<bool> {
    let evidence: Vec<f32> = mesh.vertices.iter().map(|vertex| evidence(*vertex)).collect();
    let part_of = parts(mesh);
    let mut parts = vec![MeshPart::default(); mesh.vertices.len()];
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|i| mesh.vertices[i as usize]);
        let part = &mut parts[part_of[triangle[0] as usize]];
        part.area += 0.5 * (b - a).cross(c - a).length();
        part.n_triangles += 1;
        part.evidence += triangle.iter().map(|&i| evidence[i as usize] as f64).sum::<f64>();
    }
    let largest = parts.iter().map(|part| part.area).fold(0.0, f64::max);
    let is_kept = |part: usize| parts[part].n_triangles > 0 && !parts[part].is_speck(largest);
    part_of.into_iter().map(is_kept).collect()
}

impl MeshPart {
    fn is_speck(&self, largest_area: f64) -> bool {
        let is_weak = self.evidence < LEAST_EVIDENCE * (3 * self.n_triangles) as f64;
        self.area < LARGEST_SHARE * largest_area && (is_weak || self.n_triangles < LEAST_TRIANGLES)
    }
}

/// Returns, for each vertex, the lowest vertex connected to it by triangles.
fn parts(mesh: &SurfaceMesh) -> Vec<usize> {
    let mut parent: Vec<usize> = (0..mesh.vertices.len()).collect();
    for triangle in &mesh.triangles {
        let roots = triangle.map(|i| root(&mut parent, i as usize));
        let lowest = roots.into_iter().fold(usize::MAX, usize::min);
        roots.into_iter().for_each(|i| parent[i] = lowest);
    }
    (0..parent.len()).map(|i| root(&mut parent, i)).collect()
}

/// Returns the root of a vertex; halves the path to it.
fn root(parent: &mut [usize], mut i: usize) -> usize {
    while parent[i] != i {
        parent[i] = parent[parent[i]];
        i = parent[i];
    }
    i
}

/// Returns the mesh of these vertices and the triangles between them.
pub(super) fn only(mesh: SurfaceMesh, kept: &[bool]) -> SurfaceMesh {
    let SurfaceMesh { mut vertices, mut triangles } = mesh;
    let mut number: Vec<Option<u32>> = kept.iter().map(|kept| kept.then_some(0)).collect();
    number.iter_mut().flatten().zip(0..).for_each(|(number, i)| *number = i);
    let new = |i: u32| number[i as usize].expect("its triangle is kept");
    triangles.retain(|triangle| triangle.iter().all(|&i| kept[i as usize]));
    triangles.as_flattened_mut().iter_mut().for_each(|i| *i = new(*i));
    let mut kept = kept.iter();
    vertices.retain(|_| *kept.next().expect("one for each vertex"));
    SurfaceMesh { vertices, triangles }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square sheet with `n` unit squares a side and a corner here.
    fn sheet(mesh: &mut SurfaceMesh, n: u32, corner: DVec3) {
        let first = mesh.vertices.len() as u32;
        let at = |i: u32| corner + DVec3::new((i % (n + 1)) as f64, (i / (n + 1)) as f64, 0.0);
        mesh.vertices.extend((0..(n + 1) * (n + 1)).map(at));
        for i in (0..n * n).map(|i| first + i / n * (n + 1) + i % n) {
            mesh.triangles.extend([[i, i + 1, i + n + 1], [i + 1, i + n + 2, i + n + 1]]);
        }
    }

    /// What is left of sheets with these sides, at heights 0, 1, ..., and this evidence at each height.
    fn left(sides: &[u32], evidence: &[f32]) -> SurfaceMesh {
        let mut mesh = SurfaceMesh::default();
        for (z, &n) in sides.iter().enumerate() {
            sheet(&mut mesh, n, DVec3::Z * z as f64);
        }
        without_specks(mesh, |point| evidence[point.z as usize])
    }

    #[test]
    fn small_parts_stay_if_enough_speaks_for_them() {
        let mut expected = SurfaceMesh::default();
        for (n, z) in [(100, 0.0), (9, 2.0), (11, 4.0)] {
            sheet(&mut expected, n, DVec3::Z * z);
        }
        // Weak but largest; weak and small; small and strong; strong but tiny; weak but not that small.
        assert_eq!(left(&[100, 9, 9, 5, 11], &[0.1, 1.9, 2.1, 9.0, 0.1]), expected);
    }

    #[test]
    fn a_lone_part_and_nothing_stay_as_they_are() {
        let mut lone = SurfaceMesh::default();
        sheet(&mut lone, 1, DVec3::ZERO);
        assert_eq!(left(&[1], &[0.0]), lone);
        assert_eq!(left(&[], &[]), SurfaceMesh::default());
        let with_loose_vertex = SurfaceMesh {
            vertices: [&[DVec3::ONE], &lone.vertices[..]].concat(),
            triangles: lone.triangles.iter().map(|triangle| triangle.map(|i| i + 1)).collect(),
        };
        assert_eq!(without_specks(with_loose_vertex, |_| 0.0), lone);
    }
}
