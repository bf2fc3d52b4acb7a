use super::blend::eased_mix;
use super::draw::chance;
use super::soup::Soup;
use glam::{DVec2, DVec3};
use nextview::geometry::random::Random;
use std::f64::consts::TAU;

/// Number of steps of the profile from the lower to the upper end.
const STEPS: u32 = 24;

/// A body turned about the z axis: bottle, bowl, vase, prism, pyramid.
struct Lathe {
    /// Radii at even distances from the lower to the upper end.
    knots: Vec<f64>,
    height: f64,
    wall: f64,
    /// Whether it is open at the top and hollow.
    is_hollow: bool,
    sides: u32,
    /// Its width in y, as a share of that in x.
    squash: f64,
    /// The share of the height at which the inside begins.
    floor: f64,
}

pub(super) fn make(random: &mut Random) -> Soup {
    let shape = Lathe::draw(random);
    let profile = shape.profile();
    let n = profile.len() - 1;
    Soup::sheet(shape.sides, n as u32, |u, v| {
        let (p, angle) = (profile[(v * n as f64).round() as usize], u * TAU);
        DVec3::new(p.x * angle.cos(), shape.squash * p.x * angle.sin(), p.y - shape.height * 0.5)
    })
}

impl Lathe {
    fn draw(random: &mut Random) -> Self {
        let n_knots = 2 + random.index(4);
        Self {
            knots: (0..n_knots).map(|_| random.range(0.15, 0.8)).collect(),
            height: random.range(0.4, 2.0),
            wall: random.range(0.02, 0.08),
            is_hollow: chance(random, 0.5),
            sides: if chance(random, 0.25) { 3 + random.index(6) as u32 } else { 48 },
            squash: if chance(random, 0.3) { random.range(0.4, 1.0) } else { 1.0 },
            floor: random.range(0.02, 0.3),
        }
    }

    /// Radius and height: from the axis at the bottom over the outside, and the inside if it is hollow, back
    /// to the axis.
    fn profile(&self) -> Vec<DVec2> {
        let levels = (0..=STEPS).map(|i| i as f64 / STEPS as f64);
        let mut profile = vec![DVec2::ZERO];
        profile.extend(levels.clone().map(|level| DVec2::new(self.radius(level), level * self.height)));
        if self.is_hollow {
            let inside = levels.rev().filter(|&level| level >= self.floor);
            let radius = |level| (self.radius(level) - self.wall).max(0.01);
            profile.extend(inside.map(|level| DVec2::new(radius(level), level * self.height)));
        }
        let end = if self.is_hollow { self.floor } else { 1.0 };
        profile.push(DVec2::new(0.0, end * self.height));
        profile
    }

    /// The outer radius at this share of the height.
    fn radius(&self, level: f64) -> f64 {
        let along = level * (self.knots.len() - 1) as f64;
        let i = (along as usize).min(self.knots.len() - 2);
        eased_mix(self.knots[i], self.knots[i + 1], along - i as f64)
    }
}
