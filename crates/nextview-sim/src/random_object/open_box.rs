use super::draw::chance;
use super::soup::Soup;
use glam::DVec3;
use nextview::geometry::random::Random;

/// A box without a lid, with one or two compartments, made of slabs.
struct OpenBox {
    half_sides: DVec3,
    /// Half the thickness of the walls.
    wall: f64,
    is_divided: bool,
}

pub(super) fn make(random: &mut Random) -> Soup {
    let mut soup = Soup::default();
    for (center, half_sides) in OpenBox::draw(random).slabs() {
        add_slab(&mut soup, center, half_sides);
    }
    soup
}

impl OpenBox {
    fn draw(random: &mut Random) -> Self {
        Self {
            half_sides: DVec3::new(random.range(0.4, 1.0), random.range(0.4, 1.0), random.range(0.2, 1.0)),
            wall: random.range(0.02, 0.08),
            is_divided: chance(random, 0.3),
        }
    }

    /// Centre and half-sides of the floor, the walls and the divider.
    fn slabs(&self) -> Vec<(DVec3, DVec3)> {
        let (half, wall) = (self.half_sides, self.wall);
        let mut slabs = vec![(half * DVec3::NEG_Z, half.with_z(wall))];
        for sign in [-1.0, 1.0] {
            slabs.push((half * DVec3::X * sign, half.with_x(wall)));
            slabs.push((half * DVec3::Y * sign, half.with_y(wall)));
        }
        slabs.extend(self.is_divided.then(|| (DVec3::ZERO, half.with_x(wall))));
        slabs
    }
}

/// Adds the six faces of a slab.
fn add_slab(soup: &mut Soup, center: DVec3, half_sides: DVec3) {
    for axis in 0..3 {
        for sign in [-1.0, 1.0] {
            soup.append(Soup::sheet(8, 8, |u, v| {
                let mut p = DVec3::ZERO;
                p[axis] = sign;
                p[(axis + 1) % 3] = 2.0 * u - 1.0;
                p[(axis + 2) % 3] = 2.0 * v - 1.0;
                center + p * half_sides
            }));
        }
    }
}
