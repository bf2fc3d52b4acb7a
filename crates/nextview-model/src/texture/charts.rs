/// Connected triangles coloured by one photo.
pub(super) struct Chart {
    pub photo: usize,
    /// In ascending order.
    pub triangles: Vec<usize>,
    /// Their vertices, in ascending order.
    pub vertices: Vec<u32>,
}

impl Chart {
    /// Returns the index of a vertex in the list, which must contain it.
    pub fn slot(&self, vertex: u32) -> usize {
        self.vertices.binary_search(&vertex).expect("a vertex of the chart")
    }
}

/// Returns all charts, in the order of their first triangles.
pub(super) fn charts(triangles: &[[u32; 3]], labels: &[Option<usize>], neighbors: &[Vec<u32>]) -> Vec<Chart> {
    let mut is_taken = vec![false; triangles.len()];
    let mut charts = Vec::new();
    for first in 0..triangles.len() {
        let Some(photo) = labels[first].filter(|_| !is_taken[first]) else { continue };
        let (mut members, mut open) = (Vec::new(), vec![first]);
        is_taken[first] = true;
        while let Some(i) = open.pop() {
            members.push(i);
            for next in neighbors[i].iter().map(|next| *next as usize) {
                if labels[next] == Some(photo) && !std::mem::replace(&mut is_taken[next], true) {
                    open.push(next);
                }
            }
        }
        members.sort_unstable();
        let mut vertices: Vec<u32> = members.iter().flat_map(|i| triangles[*i]).collect();
        vertices.sort_unstable();
        vertices.dedup();
        charts.push(Chart { photo, triangles: members, vertices });
    }
    charts
}
