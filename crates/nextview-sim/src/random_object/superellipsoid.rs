use super::draw::chance;
use super::soup::Soup;
use glam::DVec3;
use nextview::geometry::random::Random;
use std::f64::consts::{PI, TAU};

/// Exponents to choose from: values near 0 give boxes and cylinders, 1 is round.
const EXPONENTS: [f64; 6] = [0.05, 0.1, 0.2, 0.5, 1.0, 1.0];

/// From box through cylinder to ball (Barr 1981, "Superquadrics and angle-preserving transformations", with
/// his taper and a bend).
struct Superellipsoid {
    /// Exponent of the profile along z.
    upright: f64,
    /// Exponent of the outline seen along z.
    around: f64,
    half_sides: DVec3,
    /// Scale that may flatten it to a plate.
    flattening: DVec3,
    /// Increase in width from the middle to the upper end.
    taper: f64,
    /// Offset of the ends towards x.
    bend: f64,
}

pub(super) fn make(random: &mut Random) -> Soup {
    let shape = Superellipsoid::draw(random);
    Soup::sheet(48, 32, |u, v| shape.at(u * TAU, (v - 0.5) * PI))
}

impl Superellipsoid {
    fn draw(random: &mut Random) -> Self {
        Self {
            upright: EXPONENTS[random.index(6)],
            around: EXPONENTS[random.index(6)],
            half_sides: DVec3::new(random.range(0.25, 1.0), random.range(0.25, 1.0), random.range(0.2, 1.0)),
            flattening: DVec3::ONE.with_z(if chance(random, 0.25) { random.range(0.06, 0.2) } else { 1.0 }),
            taper: random.range(-0.5, 0.5) * f64::from(chance(random, 0.4)),
            bend: random.range(-0.6, 0.6) * f64::from(chance(random, 0.3)),
        }
    }

    /// The point at these angles in radians around the z axis and above the middle.
    fn at(&self, longitude: f64, latitude: f64) -> DVec3 {
        let outwards = signed_power(latitude.cos(), self.upright);
        let x = outwards * signed_power(longitude.cos(), self.around);
        let y = outwards * signed_power(longitude.sin(), self.around);
        let z = signed_power(latitude.sin(), self.upright);
        let width = 1.0 + self.taper * z;
        let p = DVec3::new(x * width, y * width, z) * self.half_sides * self.flattening;
        p.with_x(p.x + self.bend * p.z * p.z)
    }
}

fn signed_power(base: f64, exponent: f64) -> f64 {
    base.signum() * base.abs().powf(exponent)
}
