//! Random housings: prisms with chambers behind openings, like electrical parts.

use glam::{DVec2, DVec3};
use nextview::geometry::random::Random;
use nextview_sim::mesh::TriangleMesh;
use std::f64::consts::TAU;

/// Number of points of a loop; a multiple of 8, which gives squares corners.
const N_AROUND: usize = 24;

/// Creates the random housing of a seed, with a half-side of about 1: one opening or a grid of them at the
/// top, and possibly at the bottom, each with a chamber behind it that is at least as wide.
pub fn housing(seed: u64) -> TriangleMesh {
    let mut random = Random::new(seed, 33);
    let columns = 1 + random.index(3);
    let rows = if random.unit() < 0.5 { 1 } else { 1 + random.index(3) };
    let is_round = columns * rows == 1 && random.unit() < 0.6;
    let half = DVec2::new(random.range(0.5, 1.0), random.range(0.5, 1.0));
    let height = random.range(0.3, 1.2);
    let is_open_below = random.unit() < 0.3;
    let mut solid = HousingSolid::default();
    solid.ring(&looped(DVec2::ZERO, half, is_round, height), &looped(DVec2::ZERO, half, is_round, -height));
    for (side, has_openings) in [(1.0, true), (-1.0, is_open_below)] {
        let opening = Opening::draw(&mut random, if is_open_below { 0.9 } else { 1.8 });
        let cell = half / DVec2::new(columns as f64, rows as f64);
        for i in 0..columns * rows {
            let place = DVec2::new((i % columns) as f64, (i / columns) as f64);
            let middle = (2.0 * place + 1.0) * cell - half;
            let is_closed = !has_openings || (columns * rows > 1 && random.unit() < 0.15);
            solid.cell(middle, cell, is_round, side * height, &opening, is_closed);
        }
    }
    TriangleMesh::new(solid.vertices, solid.triangles).expect("a prism has an area")
}

/// The shape of openings, in shares of their cell and of the height.
struct Opening {
    is_round: bool,
    width: f64,
    chamber_width: f64,
    lid: f64,
    depth: f64,
}

impl Opening {
    fn draw(random: &mut Random, deepest: f64) -> Self {
        let width = random.range(0.25, 0.85);
        let chamber_width = if random.unit() < 0.5 { width } else { random.range(width, 0.93) };
        let depth = deepest * random.range(0.3, 0.95);
        let lid = depth * random.range(0.05, 0.5);
        Self { is_round: random.unit() < 0.5, width, chamber_width, lid, depth }
    }
}

/// Points around a centre, on a circle or a square with these half-sides.
fn looped(middle: DVec2, half: DVec2, is_round: bool, height: f64) -> Vec<DVec3> {
    let point = |i: usize| {
        let on_circle = DVec2::from_angle(TAU * i as f64 / N_AROUND as f64);
        let shape = if is_round { on_circle } else { on_circle / on_circle.abs().max_element() };
        (middle + half * shape).extend(height)
    };
    (0..N_AROUND).map(point).collect()
}

#[derive(Default)]
struct HousingSolid {
    vertices: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
}

impl HousingSolid {
    /// A cell of a face at this height, with or without an opening.
    fn cell(
        &mut self,
        middle: DVec2,
        half: DVec2,
        is_round: bool,
        height: f64,
        opening: &Opening,
        is_closed: bool,
    ) {
        let edge = looped(middle, half, is_round, height);
        if is_closed {
            return self.ring(&edge, &looped(middle, DVec2::ZERO, is_round, height));
        }
        let at =
            |width: f64, depth: f64| looped(middle, half * width, opening.is_round, height * (1.0 - depth));
        let loops = [
            edge,
            at(opening.width, 0.0),
            at(opening.width, opening.lid),
            at(opening.chamber_width, opening.lid),
            at(opening.chamber_width, opening.depth),
            at(0.0, opening.depth),
        ];
        loops.windows(2).for_each(|pair| self.ring(&pair[0], &pair[1]));
    }

    /// The surface between two loops.
    fn ring(&mut self, a: &[DVec3], b: &[DVec3]) {
        let first = self.vertices.len() as u32;
        self.vertices.extend(a.iter().chain(b));
        let n = a.len() as u32;
        for i in 0..n {
            let next = (i + 1) % n;
            let [a, b, c, d] = [i, next, n + i, n + next].map(|i| first + i);
            self.triangles.extend([[a, b, c], [b, d, c]]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chambers_are_inside_the_prism() {
        for seed in 0..50 {
            let mesh = housing(seed);
            let size = mesh.bounds().size();
            assert!(size.max_element() <= 2.4 && size.min_element() >= 0.5, "seed {seed}: {size}");
            assert!(mesh.triangles().len() > 4 * N_AROUND, "seed {seed}");
        }
    }
}
