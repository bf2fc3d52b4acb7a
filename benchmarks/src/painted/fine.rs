use glam::DVec3;
use nextview_sim::SimError;
use nextview_sim::mesh::TriangleMesh;
use std::collections::HashMap;

/// Returns the same surface with edges of at most this length. Triangles are cut in the middle of their
/// longest edge, together with their neighbours there.
pub fn fine(mesh: &TriangleMesh, longest_edge: f64) -> Result<TriangleMesh, SimError> {
    let mut vertices = mesh.vertices().to_vec();
    let mut middles: HashMap<[u32; 2], u32> = HashMap::new();
    let (mut open, mut done) = (mesh.triangles().to_vec(), Vec::new());
    while let Some([a, b, c]) = open.pop() {
        let edge = |[from, to]: [u32; 2]| vertices[from as usize].distance(vertices[to as usize]);
        let turned = [[a, b, c], [b, c, a], [c, a, b]];
        let [a, b, c] = turned
            .into_iter()
            .fold(turned[0], |x, y| if edge([y[0], y[1]]) > edge([x[0], x[1]]) { y } else { x });
        if edge([a, b]) <= longest_edge {
            done.push([a, b, c]);
            continue;
        }
        let middle = *middles.entry([a.min(b), a.max(b)]).or_insert_with(|| {
            let middle: DVec3 = 0.5 * (vertices[a as usize] + vertices[b as usize]);
            vertices.push(middle);
            vertices.len() as u32 - 1
        });
        open.extend([[a, middle, c], [middle, b, c]]);
    }
    TriangleMesh::new(vertices, done)
}
