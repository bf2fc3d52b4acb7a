use glam::DVec3;

/// The convex hull of at most four points.
#[derive(Clone, Debug, Default)]
pub(super) struct Simplex {
    points: [DVec3; 4],
    n: usize,
}

impl Simplex {
    fn of(points: &[DVec3]) -> Self {
        let mut simplex = Self::default();
        simplex.points[..points.len()].copy_from_slice(points);
        simplex.n = points.len();
        simplex
    }

    pub fn points(&self) -> &[DVec3] {
        &self.points[..self.n]
    }

    /// Adds a point; [`reduce`](Self::reduce) must have been called since the last one.
    pub fn push(&mut self, point: DVec3) {
        self.points[self.n] = point;
        self.n += 1;
    }

    /// Returns the point of the hull nearest to the origin. Keeps only the points that span it: all four only
    /// if the origin is inside.
    pub fn reduce(&mut self) -> DVec3 {
        let (nearest, kept) = match *self.points() {
            [a, b] => on_segment(a, b),
            [a, b, c] => on_triangle(a, b, c),
            [a, b, c, d] => in_tetrahedron(a, b, c, d),
            [a] => (a, self.clone()),
            _ => (DVec3::ZERO, self.clone()),
        };
        *self = kept;
        nearest
    }
}

fn on_segment(a: DVec3, b: DVec3) -> (DVec3, Simplex) {
    let along = b - a;
    let t = -a.dot(along);
    if t <= 0.0 {
        (a, Simplex::of(&[a]))
    } else if t >= along.length_squared() {
        (b, Simplex::of(&[b]))
    } else {
        (a + along * (t / along.length_squared()), Simplex::of(&[a, b]))
    }
}

/// Uses the regions of a triangle (Ericson, Real-Time Collision Detection, 2005, section 5.1.5).
fn on_triangle(a: DVec3, b: DVec3, c: DVec3) -> (DVec3, Simplex) {
    let (ab, ac, bc) = (b - a, c - a, c - b);
    let normal = ab.cross(ac);
    let is_beyond = |from: DVec3, edge: DVec3| edge.cross(normal).dot(-from) > 0.0;
    let size = normal.length_squared();
    let edges = [(a, b, is_beyond(a, ab)), (b, c, is_beyond(b, bc)), (c, a, is_beyond(c, -ac))];
    // Without area, there is no inside.
    let is_flat = size <= 1e-20 * ab.length_squared() * ac.length_squared();
    if !is_flat && edges.iter().all(|(_, _, is_beyond)| !is_beyond) {
        return (normal * (a.dot(normal) / size), Simplex::of(&[a, b, c]));
    }
    let candidates = edges.iter().filter(|edge| is_flat || edge.2).map(|&(from, to, _)| on_segment(from, to));
    nearest_of(candidates)
}

fn in_tetrahedron(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> (DVec3, Simplex) {
    let faces = [(a, b, c, d), (a, c, d, b), (a, d, b, c), (b, d, c, a)];
    let candidates = faces.into_iter().filter(|&(a, b, c, inner)| {
        let normal = (b - a).cross(c - a);
        // In a flat tetrahedron, no side of a face is the inside.
        let height = normal.dot(inner - a);
        let is_flat = height.abs() <= 1e-10 * normal.length() * (inner - a).length();
        is_flat || normal.dot(-a) * height <= 0.0
    });
    let candidates: Vec<_> = candidates.map(|(a, b, c, _)| on_triangle(a, b, c)).collect();
    if candidates.is_empty() {
        return (DVec3::ZERO, Simplex::of(&[a, b, c, d]));
    }
    nearest_of(candidates.into_iter())
}

fn nearest_of(candidates: impl Iterator<Item = (DVec3, Simplex)>) -> (DVec3, Simplex) {
    let nearer = |a: (DVec3, Simplex), b: (DVec3, Simplex)| {
        if b.0.length_squared() < a.0.length_squared() { b } else { a }
    };
    candidates.reduce(nearer).expect("there is a side that the origin is beyond")
}

#[cfg(test)]
mod tests {
    use super::*;
    use nextview::geometry::random::Random;

    /// The slow twin tries all combinations of the points on a grid.
    #[test]
    fn the_nearest_point_is_nearest() {
        let mut random = Random::new(3, 0);
        for case in 0..300 {
            let n = 1 + case % 4;
            let shift = random.in_cube() * random.range(0.0, 2.0);
            let points: Vec<DVec3> = (0..n).map(|_| random.in_cube() + shift).collect();
            let mut simplex = Simplex::of(&points);
            let nearest = simplex.reduce().length();
            let mut best = f64::INFINITY;
            let steps = 30;
            for i in 0..=steps {
                for j in 0..=steps - i {
                    for k in 0..=steps - i - j {
                        let weights = [i, j, k, steps - i - j - k].map(|w| f64::from(w) / f64::from(steps));
                        if weights[n..].iter().all(|w| *w == 0.0) {
                            let mixed: DVec3 = points.iter().zip(weights).map(|(p, w)| *p * w).sum();
                            best = best.min(mixed.length());
                        }
                    }
                }
            }
            assert!(nearest <= best + 1e-12 && best <= nearest + 0.15, "{nearest}, {best} for {points:?}");
            assert!((simplex.clone().reduce().length() - nearest).abs() < 1e-12, "kept points suffice");
        }
    }
}
