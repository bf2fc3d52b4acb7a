use super::soup::Soup;
use glam::DVec3;
use nextview::geometry::random::Random;
use std::f64::consts::{PI, TAU};

/// An ellipsoid with bumps and dents, such as a stone, a fruit or dough.
struct Blob {
    waves: [Wave; 6],
    half_sides: DVec3,
}

/// A plane wave through the ball that the blob is made from.
struct Wave {
    /// Radians per radius of the ball.
    direction: DVec3,
    phase: f64,
    amplitude: f64,
}

pub(super) fn make(random: &mut Random) -> Soup {
    let blob = Blob::draw(random);
    Soup::sheet(64, 32, |u, v| {
        let (longitude, latitude) = (u * TAU, (v - 0.5) * PI);
        let outwards = latitude.cos();
        blob.at(DVec3::new(outwards * longitude.cos(), outwards * longitude.sin(), latitude.sin()))
    })
}

impl Blob {
    fn draw(random: &mut Random) -> Self {
        let waves = [(); 6].map(|()| Wave::draw(random));
        let half_sides = DVec3::new(random.range(0.4, 1.0), random.range(0.4, 1.0), random.range(0.4, 1.0));
        Self { waves, half_sides }
    }

    /// The point in this direction, a unit vector.
    fn at(&self, direction: DVec3) -> DVec3 {
        let radius = 1.0 + self.waves.iter().map(|wave| wave.at(direction)).sum::<f64>();
        direction * radius * self.half_sides
    }
}

impl Wave {
    fn draw(random: &mut Random) -> Self {
        let direction = random.in_cube() * 4.0;
        Self { direction, phase: random.range(0.0, TAU), amplitude: random.range(0.03, 0.2) }
    }

    fn at(&self, p: DVec3) -> f64 {
        self.amplitude * (self.direction.dot(p) + self.phase).sin()
    }
}
