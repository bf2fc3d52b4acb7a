//! Angles in files, for `serde(with = "crate::degrees")`: radians in the program, degrees in the file.

use serde::{Deserialize, Deserializer, Serializer};

/// Converts to degrees, rounded so that 10 degrees does not become 9.999999999999998.
pub(crate) fn tidy(radians: f64) -> f64 {
    (radians.to_degrees() * 1e9).round() / 1e9
}

pub(crate) fn serialize<S: Serializer>(radians: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_f64(tidy(*radians))
}

pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    f64::deserialize(deserializer).map(f64::to_radians)
}
