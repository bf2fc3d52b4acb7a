//! Choices that users make by name.

use super::names::{Named, named};
use crate::Fault;
use glam::DVec3;
use nextview::view::{ViewSpace, generate};
use serde::{Deserialize, Serialize};
use std::ops::RangeInclusive;

named! {
    /// A named set of defaults.
    #[derive(Default)]
    pub enum Profile {
        Paper = "paper": "The paper's formulas, 5000 candidates, voxels of 1 cm, stop at q_thresh = 0.5; as in its authors' program, only points on the object count and rays are thin",
        #[default] Default = "default": "The best settings: the planner most-surface; what the camera sees \
                                         past the object carves free space",
    }
}

named! {
    /// How the object's box is determined.
    #[derive(Default)]
    pub enum BoxRule {
        #[default] Known = "known": "The box is known",
        Grows = "grows": "Nothing is known: the box begins with the first image and grows, and the \
                          candidates move with it",
    }
}

named! {
    /// The surface below the object.
    #[derive(Default)]
    pub enum TableRule {
        #[default] None = "none": "The object floats in the room",
        Known = "known": "It stands on a table whose height is known",
        Fit = "fit": "It stands on a table that is found in the first image",
    }
}

named! {
    /// The unit of a mesh file.
    #[derive(Default)]
    pub enum UnitName {
        M = "m": "Metres",
        Mm = "mm": "Millimetres",
        #[default] Auto = "auto": "Guessed from the longest side: metres up to 2, millimetres from 20, an \
                                   error in between",
    }
}

#[cfg(feature = "simulated")]
impl From<UnitName> for nextview_sim::mesh::Unit {
    fn from(name: UnitName) -> Self {
        match name {
            UnitName::M => Self::Metres,
            UnitName::Mm => Self::Millimetres,
            UnitName::Auto => Self::Auto,
        }
    }
}

named! {
    /// The length that `size_m` sets.
    #[derive(Default)]
    pub enum SizeOf {
        #[default] LongestSide = "longest-side": "The longest side of its box",
        ShortestSide = "shortest-side": "The shortest side of its box, whose middle is moved to the origin",
        Radius = "radius": "The largest distance of its surface from the surface's centroid, which is moved to the origin; candidates look there",
    }
}

named! {
    /// A rule that generates view candidates.
    #[derive(Default)]
    pub enum ViewRule {
        #[default] Shell = "shell": "The paper's random shell: outside the cube of half-side 2 x size, inside the sphere of radius 4 x size",
        Sphere = "sphere": "A Fibonacci sphere of radius 3 x size",
        Hemisphere = "hemisphere": "The upper half of it, for an object on a table",
        Tammes = "tammes": "A sphere of radius 3 x size with candidates as far apart as possible, at most 1000",
        Rings = "rings": "24 rings of latitude on a sphere of radius 3 x size",
        Ring = "ring": "A circle of radius 3 x size, 30 degrees up: a turntable in front of a fixed camera",
    }
}

impl SizeOf {
    /// Whether it is the longest side.
    pub fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

/// Half-sides of objects that views can be generated for, in metres.
const SIZES_M: RangeInclusive<f64> = 1e-6..=1e6;

/// Elevation of the ring above the object's middle: sides and top are then in view.
const RING_ELEVATION_DEG: f64 = 30.0;

impl ViewRule {
    /// Generates the candidates around an object of this centre and half-side in metres. All but those of the
    /// shell are at this distance from the centre in metres; the default is three times the half-side.
    pub fn views(
        self,
        center: DVec3,
        size: f64,
        distance: Option<f64>,
        n: usize,
        seed: u64,
    ) -> Result<ViewSpace, Fault> {
        if !SIZES_M.contains(&size) {
            return Err(Fault::of_value("size_m", size, "0.000001 to 1000000 m"));
        }
        // Farther away, rounding of positions is too coarse for the smallest objects.
        if !(center.is_finite() && center.abs().max_element() <= *SIZES_M.end()) {
            return Err(Fault::of_value("center", center, "coordinates of -1000000 to 1000000 m"));
        }
        let distance = distance.unwrap_or(3.0 * size);
        Ok(match self {
            Self::Shell => generate::shell(center, size, n, seed)?,
            Self::Sphere => generate::fibonacci_sphere(center, distance, n)?,
            Self::Hemisphere => generate::hemisphere(center, distance, n)?,
            Self::Tammes => generate::tammes(center, distance, n)?,
            Self::Rings => generate::latitude_rings(center, distance, n)?,
            Self::Ring => generate::ring(center, distance, RING_ELEVATION_DEG.to_radians(), n)?,
        })
    }
}

/// The name of a [`ViewRule`], or a CSV file of poses.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(transparent)]
pub struct ViewSpaceName(pub String);

impl ViewSpaceName {
    /// The rule; `None` if it is a file.
    pub fn rule(&self) -> Option<ViewRule> {
        ViewRule::of_name(&self.0)
    }
}
