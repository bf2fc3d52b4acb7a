use super::draw::chance;
use super::soup::Soup;
use glam::DVec3;
use nextview::geometry::random::Random;
use std::f64::consts::TAU;

/// A bar with an elliptic section along a curve: handle, hook, ring, worm.
struct Tube {
    course: Course,
    /// Half the section's sides, across and along the normal of the curve.
    radii: [f64; 2],
}

enum Course {
    /// Around the z axis by this angle in radians; a whole turn is a ring.
    Arc(f64),
    /// A cubic Bezier curve with these control points.
    Bezier([DVec3; 4]),
}

pub(super) fn make(random: &mut Random) -> Soup {
    let tube = Tube::draw(random);
    Soup::sheet(48, 24, |u, v| tube.at(u, v * TAU))
}

impl Tube {
    fn draw(random: &mut Random) -> Self {
        let is_arc = chance(random, 0.5);
        let extent = if chance(random, 0.3) { TAU } else { random.range(1.5, 5.5) };
        let control = [(); 4].map(|()| random.in_cube());
        let course = if is_arc { Course::Arc(extent) } else { Course::Bezier(control) };
        Self { course, radii: [random.range(0.04, 0.25), random.range(0.04, 0.25)] }
    }

    /// The point at this share of the way and this angle around it.
    fn at(&self, way: f64, angle: f64) -> DVec3 {
        let (before, after) = (self.course.at((way - 0.01).max(0.0)), self.course.at((way + 0.01).min(1.0)));
        let along = (after - before).normalize_or(DVec3::X);
        let across = match self.course {
            Course::Arc(_) => DVec3::Z,
            Course::Bezier(_) => along.any_orthonormal_vector(),
        };
        let normal = along.cross(across);
        let section = across * self.radii[0] * angle.cos() + normal * self.radii[1] * angle.sin();
        self.course.at(way) + section * self.fullness(way)
    }

    /// Shrinks the section to nothing towards the ends, which closes them.
    fn fullness(&self, way: f64) -> f64 {
        match self.course {
            Course::Arc(extent) if extent >= TAU => 1.0,
            _ => (way.min(1.0 - way) * 12.0).min(1.0).sqrt(),
        }
    }
}

impl Course {
    fn at(&self, t: f64) -> DVec3 {
        match self {
            Self::Arc(extent) => DVec3::new(0.7 * (t * extent).cos(), 0.7 * (t * extent).sin(), 0.0),
            Self::Bezier([a, b, c, d]) => {
                let s = 1.0 - t;
                a * s * s * s + b * 3.0 * s * s * t + c * 3.0 * s * t * t + d * t * t * t
            }
        }
    }
}
