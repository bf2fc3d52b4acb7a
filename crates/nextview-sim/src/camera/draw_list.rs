use super::chunk::{Chunk, LANES};
use crate::mesh::TriangleMesh;
use glam::DVec3;
use std::ops::Range;

/// A mesh in drawing order: clusters of nearby triangles. Hidden parts and parts outside the image are
/// skipped in large pieces, and all work on one piece stays in the cache.
///
/// The vertices are stored in chunks; the last chunk of a cluster is padded with its first vertex.
#[derive(Default)]
pub(super) struct DrawList {
    pub vertices: Vec<[Chunk; 3]>,
    /// Each triangle's corners, counted from the first vertex of its cluster.
    pub triangles: Vec<[u16; 3]>,
    pub clusters: Vec<Cluster>,
}

/// Neighbouring triangles, with vertices of their own.
pub(super) struct Cluster {
    /// Chunks of the list.
    pub vertices: Range<usize>,
    pub triangles: Range<usize>,
    /// The middle of the vertices' box.
    pub center: DVec3,
    /// Upper bound on the length of its edges, metres.
    pub longest_edge: f64,
}

impl Cluster {
    /// Large enough to pay for its tests, small enough to be hidden behind others.
    pub const MAX_TRIANGLES: usize = 128;

    /// Chunks of vertices if no two triangles share one.
    pub const MAX_CHUNKS: usize = 3 * Self::MAX_TRIANGLES / LANES;
}

impl DrawList {
    /// Cuts the mesh into clusters.
    pub fn new(mesh: &TriangleMesh) -> Self {
        let centroid = |i: usize| mesh.corners(i).into_iter().sum::<DVec3>() / 3.0;
        let mut order: Vec<(DVec3, usize)> = (0..mesh.triangles().len()).map(|i| (centroid(i), i)).collect();
        sort_into_clusters(&mut order);

        let mut list = Self::default();
        let mut number_of = vec![None; mesh.vertices().len()];
        for members in order.chunks(Cluster::MAX_TRIANGLES) {
            list.push(mesh, members.iter().map(|&(_, i)| i), &mut number_of);
        }
        list
    }

    /// Appends a cluster. `number_of` is working memory: it maps the mesh's vertices to their numbers in the
    /// cluster, and is empty before and after.
    fn push(
        &mut self,
        mesh: &TriangleMesh,
        members: impl Iterator<Item = usize> + Clone,
        number_of: &mut [Option<u16>],
    ) {
        let (first_chunk, first_triangle) = (self.vertices.len(), self.triangles.len());
        let mut vertices = Vec::new();
        for i in members.clone() {
            let corners = mesh.triangles()[i].map(|old| {
                *number_of[old as usize].get_or_insert_with(|| {
                    vertices.push(mesh.vertices()[old as usize]);
                    (vertices.len() - 1) as u16
                })
            });
            self.triangles.push(corners);
        }
        members.clone().flat_map(|i| mesh.triangles()[i]).for_each(|old| number_of[old as usize] = None);
        vertices.resize(vertices.len().next_multiple_of(LANES), vertices[0]);
        self.vertices.extend(
            vertices
                .chunks_exact(LANES)
                .map(|chunk| [0, 1, 2].map(|axis| std::array::from_fn(|i| chunk[i][axis]))),
        );
        self.clusters.push(Cluster {
            vertices: first_chunk..self.vertices.len(),
            triangles: first_triangle..self.triangles.len(),
            center: box_center(members.clone().flat_map(|i| mesh.corners(i))),
            longest_edge: members.map(|i| longest_edge(mesh.corners(i))).fold(0.0, f64::max),
        });
    }

    /// Returns vertex `i` of a cluster in world coordinates.
    pub fn vertex(&self, cluster: &Cluster, i: u16) -> DVec3 {
        let (chunk, lane) = (cluster.vertices.start + i as usize / LANES, i as usize % LANES);
        DVec3::from_array(self.vertices[chunk].map(|coordinate| coordinate[lane]))
    }
}

/// Sorts triangles so that each run of [`Cluster::MAX_TRIANGLES`] is compact: halves them along the longest
/// side of their box down to such runs.
fn sort_into_clusters(triangles: &mut [(DVec3, usize)]) {
    if triangles.len() <= Cluster::MAX_TRIANGLES {
        return;
    }
    let first = triangles[0].0;
    let (low, high) = triangles.iter().fold((first, first), |(l, h), (c, _)| (l.min(*c), h.max(*c)));
    let axis = (high - low).max_position();
    let middle = (triangles.len() / 2).next_multiple_of(Cluster::MAX_TRIANGLES);
    triangles.select_nth_unstable_by(middle, |a, b| a.0[axis].total_cmp(&b.0[axis]));
    let (below, above) = triangles.split_at_mut(middle);
    sort_into_clusters(below);
    sort_into_clusters(above);
}

fn box_center(points: impl Iterator<Item = DVec3>) -> DVec3 {
    let (low, high) = points.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
    0.5 * (low + high)
}

fn longest_edge([a, b, c]: [DVec3; 3]) -> f64 {
    a.distance(b).max(b.distance(c)).max(c.distance(a))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn holds_the_same_triangles() {
        let point = |i: usize| DVec3::new((i * 7 % 11) as f64, (i * 5 % 13) as f64, (i % 3) as f64);
        let triangles: Vec<[u32; 3]> =
            (0..600).map(|i| [i, (i * 3 + 1) % 50, (i * 7 + 2) % 50].map(|v| v % 50)).collect();
        let mesh = TriangleMesh::new((0..55).map(point).collect(), triangles).unwrap();
        let list = DrawList::new(&mesh);
        assert!(list.clusters.len() > 2);
        let sorted = |mut corners: Vec<[DVec3; 3]>| {
            corners.sort_by(|a, b| format!("{a:?}").cmp(&format!("{b:?}")));
            corners
        };
        let corners_in = |cluster: &Cluster| {
            let of_triangle = |t: &[u16; 3]| t.map(|v| list.vertex(cluster, v));
            list.triangles[cluster.triangles.clone()].iter().map(of_triangle).collect::<Vec<_>>()
        };
        for cluster in &list.clusters {
            assert!(corners_in(cluster).into_iter().all(|t| longest_edge(t) <= cluster.longest_edge));
        }
        let drawn = list.clusters.iter().flat_map(corners_in).collect();
        let given = (0..mesh.triangles().len()).map(|i| mesh.corners(i)).collect();
        assert_eq!(sorted(drawn), sorted(given));
    }
}
