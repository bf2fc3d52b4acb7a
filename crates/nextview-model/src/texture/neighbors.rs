/// Returns, for each triangle, those that share an edge with it, in ascending order.
pub(super) fn of_triangles(triangles: &[[u32; 3]]) -> Vec<Vec<u32>> {
    let mut edges: Vec<(u32, u32, u32)> = Vec::with_capacity(3 * triangles.len());
    for (&[a, b, c], i) in triangles.iter().zip(0..) {
        edges.extend([(a, b), (b, c), (c, a)].map(|(a, b)| (a.min(b), a.max(b), i)));
    }
    edges.sort_unstable();
    let mut neighbors = vec![Vec::new(); triangles.len()];
    for edge in edges.chunk_by(|one, other| (one.0, one.1) == (other.0, other.1)) {
        // More than a few triangles at an edge do not form a surface.
        for (i, one) in edge.iter().enumerate().take(4) {
            for other in edge[..i].iter().filter(|other| other.2 != one.2) {
                neighbors[one.2 as usize].push(other.2);
                neighbors[other.2 as usize].push(one.2);
            }
        }
    }
    for list in &mut neighbors {
        list.sort_unstable();
        list.dedup();
    }
    neighbors
}
