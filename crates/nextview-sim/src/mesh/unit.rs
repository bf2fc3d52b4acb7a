use super::{FileMesh, TriangleMesh};
use crate::SimError;
use std::fmt;

/// The unit of the numbers in a mesh file.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Unit {
    /// The format's unit (glTF: metres). Otherwise guessed from the longest side: metres up to 2, millimetres
    /// from 20 on, an error in between. Fits objects of 2 cm to 2 m.
    #[default]
    Auto,
    /// One metre.
    Metres,
    /// One millimetre.
    Millimetres,
    /// The unit that makes the longest side this many metres; a positive finite number.
    LongestSide(f64),
}

/// The conversion of a file's numbers to metres. Its text describes it in words.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scaling {
    /// Metres per unit of the file.
    pub metres_per_unit: f64,
    /// Longest side of the mesh in the file's unit.
    pub longest_side: f64,
    /// Source of the unit.
    pub source: UnitSource,
}

/// The source of a file's unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UnitSource {
    /// Stated by the caller.
    Stated,
    /// Defined by the file format.
    Format,
    /// Guessed from the mesh's size.
    Guessed,
}

impl fmt::Display for Scaling {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let side_m = self.longest_side * self.metres_per_unit;
        let source = match self.source {
            UnitSource::Stated => "as stated",
            UnitSource::Format => "as the file format defines",
            UnitSource::Guessed => "guessed from the size",
        };
        write!(f, "1 unit of the file is {} m ({source}); longest side {side_m:.4} m", self.metres_per_unit)
    }
}

impl FileMesh {
    /// Returns the mesh in metres, and the interpretation of its numbers.
    ///
    /// Fails if [`Unit::Auto`] finds no unit, or if the requested longest side is not a positive number.
    pub fn to_metres(&self, unit: Unit) -> Result<(TriangleMesh, Scaling), SimError> {
        let longest_side = self.longest_side();
        let (metres_per_unit, source) = match unit {
            Unit::Metres => (1.0, UnitSource::Stated),
            Unit::Millimetres => (0.001, UnitSource::Stated),
            Unit::LongestSide(side) if side > 0.0 && side.is_finite() => {
                (side / longest_side, UnitSource::Stated)
            }
            Unit::LongestSide(side) => {
                return Err(SimError::parameter("size_m", side, "a positive number of metres"));
            }
            Unit::Auto if self.has_metres() => (1.0, UnitSource::Format),
            Unit::Auto if longest_side <= 2.0 => (1.0, UnitSource::Guessed),
            Unit::Auto if longest_side >= 20.0 => (0.001, UnitSource::Guessed),
            Unit::Auto => return Err(self.error(SimError::AmbiguousUnit { longest_side })),
        };
        let mesh = self.mesh().scaled(metres_per_unit).map_err(|error| self.error(error))?;
        Ok((mesh, Scaling { metres_per_unit, longest_side, source }))
    }
}
