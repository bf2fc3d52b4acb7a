use super::blend::{eased_mix, mix};
use super::draw::chance;
use super::soup::Soup;
use glam::{DVec2, DVec3};
use nextview::geometry::random::Random;
use std::f64::consts::TAU;

/// A flat outline extruded along z: plate, gear, star, nut, polygon.
struct Extrusion {
    /// Whether the outline is curved between its corners.
    is_smooth: bool,
    /// Distances of the corners from the z axis, evenly spread around it.
    radii: Vec<f64>,
    /// The hole in the middle as a share of the outline; 0 for none.
    hole: f64,
    height: f64,
}

pub(super) fn make(random: &mut Random) -> Soup {
    let shape = Extrusion::draw(random);
    Soup::sheet(shape.radii.len() as u32 * 12, 16, |u, v| shape.at(u, v))
}

impl Extrusion {
    fn draw(random: &mut Random) -> Self {
        let n = 3 + random.index(10);
        let depth = random.range(0.0, 0.6);
        let is_irregular = chance(random, 0.5);
        let is_smooth = chance(random, 0.4);
        let mut radius = |i| match (is_irregular, i % 2) {
            (true, _) => random.range(0.4, 1.0),
            (false, 0) => 1.0,
            (false, _) => 1.0 - depth,
        };
        Self {
            is_smooth,
            radii: (0..n).map(&mut radius).collect(),
            hole: if chance(random, 0.5) { random.range(0.15, 0.7) } else { 0.0 },
            height: if chance(random, 0.4) { random.range(0.05, 0.2) } else { random.range(0.2, 1.2) },
        }
    }

    /// The point at a share of the way around the z axis, and a share of the way from the hole along the
    /// lower face, up the outside, back along the upper face and down the hole.
    fn at(&self, around: f64, along: f64) -> DVec3 {
        let section = [(self.hole, -1.0), (1.0, -1.0), (1.0, 1.0), (self.hole, 1.0), (self.hole, -1.0)];
        let along = along * 4.0;
        let i = (along as usize).min(3);
        let ((from, below), (to, above)) = (section[i], section[i + 1]);
        let share = along - i as f64;
        let outline = self.outline(around) * mix(from, to, share);
        outline.extend(mix(below, above, share) * self.height * 0.5)
    }

    fn outline(&self, around: f64) -> DVec2 {
        let n = self.radii.len();
        let along = around.rem_euclid(1.0) * n as f64;
        let (i, share) = (along as usize % n, along.fract());
        let radius = |i: usize| self.radii[i % n];
        let corner = |i: usize| DVec2::from_angle(i as f64 / n as f64 * TAU) * radius(i);
        match self.is_smooth {
            true => DVec2::from_angle(around * TAU) * eased_mix(radius(i), radius(i + 1), share),
            false => corner(i).lerp(corner(i + 1), share),
        }
    }
}
