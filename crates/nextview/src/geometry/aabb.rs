use crate::Error;
use crate::checked::checked_when_read;
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// An axis-aligned box in metres, closed on all sides.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, remote = "Self")]
pub struct Aabb {
    /// Lowest corner, metres.
    #[serde(rename = "min_m")]
    #[cfg_attr(feature = "schema", schemars(with = "[f64; 3]"))]
    pub min: DVec3,
    /// Highest corner, metres; never below `min`.
    #[serde(rename = "max_m")]
    #[cfg_attr(feature = "schema", schemars(with = "[f64; 3]"))]
    pub max: DVec3,
}

checked_when_read!(Aabb);

impl Aabb {
    /// All of space.
    pub const EVERYWHERE: Self = Self { min: DVec3::NEG_INFINITY, max: DVec3::INFINITY };

    /// Fails if a corner is NaN or `min` is above `max` on any axis.
    pub fn check(&self) -> Result<(), Error> {
        if self.min.cmple(self.max).all() {
            return Ok(());
        }
        Err(Error::invalid("box", format!("{} to {}", self.min, self.max), "the lowest corner first"))
    }

    /// Returns the cube around `center` with half-side `half`, metres.
    pub fn cube(center: DVec3, half: f64) -> Self {
        Self { min: center - DVec3::splat(half), max: center + DVec3::splat(half) }
    }

    /// Returns the bounding box of the points; `None` if there are no points.
    pub fn around(points: impl IntoIterator<Item = DVec3>) -> Option<Self> {
        points
            .into_iter()
            .map(|p| Self { min: p, max: p })
            .reduce(|a, b| Self { min: a.min.min(b.min), max: a.max.max(b.max) })
    }

    /// Returns the centre of the box.
    pub fn center(&self) -> DVec3 {
        0.5 * (self.min + self.max)
    }

    /// Returns the edge lengths in metres.
    pub fn size(&self) -> DVec3 {
        self.max - self.min
    }

    /// Returns the longest edge in metres.
    pub fn longest_side(&self) -> f64 {
        self.size().max_element()
    }

    /// Whether the point lies inside or on the border.
    pub fn contains(&self, point: DVec3) -> bool {
        point.cmpge(self.min).all() && point.cmple(self.max).all()
    }

    /// Returns the squared distance of a point from the box, 0 inside.
    pub(crate) fn distance_squared(&self, point: DVec3) -> f64 {
        (self.min - point).max(point - self.max).max(DVec3::ZERO).length_squared()
    }

    /// Returns the largest dot product of the direction with a point of the box.
    pub(crate) fn most_along(&self, direction: DVec3) -> f64 {
        (self.min * direction).max(self.max * direction).element_sum()
    }

    /// Returns the eight corners, x varying fastest.
    pub fn corners(&self) -> [DVec3; 8] {
        std::array::from_fn(|i| {
            let pick = |bit: usize, low: f64, high: f64| if i >> bit & 1 == 0 { low } else { high };
            DVec3::new(
                pick(0, self.min.x, self.max.x),
                pick(1, self.min.y, self.max.y),
                pick(2, self.min.z, self.max.z),
            )
        })
    }

    /// Returns the part `t_in..=t_out` of the line `origin + t * direction`, restricted to `0..=t_max`, that
    /// lies in the box; `None` if it misses the box. A line parallel to a face and inside the slab counts as
    /// inside.
    pub fn clip(&self, origin: DVec3, direction: DVec3, t_max: f64) -> Option<(f64, f64)> {
        let (mut t_in, mut t_out) = (0.0_f64, t_max);
        for axis in 0..3 {
            if direction[axis] == 0.0 {
                if origin[axis] < self.min[axis] || origin[axis] > self.max[axis] {
                    return None;
                }
                continue;
            }
            let inverse = 1.0 / direction[axis];
            let a = (self.min[axis] - origin[axis]) * inverse;
            let b = (self.max[axis] - origin[axis]) * inverse;
            t_in = t_in.max(a.min(b));
            t_out = t_out.min(a.max(b));
        }
        (t_in <= t_out).then_some((t_in, t_out))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clips_lines_that_cross_graze_and_miss() {
        let unit = Aabb { min: DVec3::ZERO, max: DVec3::ONE };
        assert_eq!(unit.clip(DVec3::new(-1.0, 0.5, 0.5), DVec3::X, 9.0), Some((1.0, 2.0)));
        assert_eq!(unit.clip(DVec3::new(-1.0, 0.5, 0.5), DVec3::X, 1.5), Some((1.0, 1.5)));
        assert_eq!(unit.clip(DVec3::new(-1.0, 1.0, 0.5), DVec3::X, 9.0), Some((1.0, 2.0)), "on a face");
        assert_eq!(unit.clip(DVec3::new(-1.0, 1.5, 0.5), DVec3::X, 9.0), None);
        assert_eq!(unit.clip(DVec3::new(0.5, 0.5, 0.5), -DVec3::Z, 9.0), Some((0.0, 0.5)));
    }
}
