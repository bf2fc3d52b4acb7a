use glam::DVec3;

/// Triangles that may cross each other, not yet checked.
#[derive(Clone, Debug, Default)]
pub(super) struct Soup {
    pub vertices: Vec<DVec3>,
    pub triangles: Vec<[u32; 3]>,
}

impl Soup {
    /// A sheet of `rows` times `columns` cells, cut into two triangles each. `at` gives the point for a share
    /// of the rows and a share of the columns, both from 0 to 1.
    pub fn sheet(rows: u32, columns: u32, at: impl Fn(f64, f64) -> DVec3) -> Self {
        let share = |i: u32, n: u32| i as f64 / n as f64;
        let row = |i| (0..=columns).map(move |j| (share(i, rows), share(j, columns)));
        let vertices = (0..=rows).flat_map(row).map(|(u, v)| at(u, v)).collect();
        let below = columns + 1;
        let corners = (0..rows).flat_map(|i| (0..columns).map(move |j| i * below + j));
        let cell = |a| [[a, a + below, a + 1], [a + 1, a + below, a + below + 1]];
        Self { vertices, triangles: corners.flat_map(cell).collect() }
    }

    /// Moves all vertices.
    pub fn map(mut self, place: impl Fn(DVec3) -> DVec3) -> Self {
        self.vertices.iter_mut().for_each(|vertex| *vertex = place(*vertex));
        self
    }

    /// Adds the triangles of another.
    pub fn append(&mut self, other: Self) {
        let n_before = self.vertices.len() as u32;
        self.vertices.extend(other.vertices);
        self.triangles.extend(other.triangles.iter().map(|corners| corners.map(|i| i + n_before)));
    }
}
