//! Arrays of numbers in few bytes, as base64.

use base64::prelude::{BASE64_STANDARD, Engine};
use glam::Vec3;

/// Positions with 16 bits per coordinate.
#[derive(Debug, Default, PartialEq)]
pub(super) struct PackedPositions {
    /// Three little-endian 16-bit numbers per position.
    pub data: String,
    /// Lowest corner, metres.
    pub min: Vec3,
    /// Size of one unit along each axis, metres: 15 micrometres for an object of 1 m.
    pub unit: Vec3,
}

impl PackedPositions {
    /// Packs finite positions.
    pub fn of(points: &[Vec3]) -> Self {
        let min = points.iter().copied().reduce(Vec3::min).unwrap_or_default();
        let max = points.iter().copied().reduce(Vec3::max).unwrap_or_default();
        let unit = (max - min) / u16::MAX as f32;
        // A flat cloud has a unit of 0 and gives 0 / 0, which converts to 0.
        let steps = |point: &Vec3| ((*point - min) / unit).to_array().map(|step| step.round() as u16);
        let bytes = points.iter().flat_map(steps).flat_map(u16::to_le_bytes);
        Self { data: base64(bytes), min, unit }
    }

    /// The positions as a JSON object.
    pub fn json(&self) -> String {
        let Self { data, min, unit } = self;
        // Enough digits for 65535 units to stay exact to a unit.
        let [min, unit] = [min, unit].map(|v| format!("[{:e},{:e},{:e}]", v.x, v.y, v.z));
        format!(r#"{{"min":{min},"unit":{unit},"data":"{data}"}}"#)
    }
}

/// Bytes as base64.
pub(super) fn base64(bytes: impl IntoIterator<Item = u8>) -> String {
    BASE64_STANDARD.encode(bytes.into_iter().collect::<Vec<u8>>())
}

/// Indices as differences from the previous one, seven bits per byte, the lowest first, the sign in the
/// lowest bit. Neighbouring triangles use neighbouring vertices, so most take one or two bytes.
pub(super) fn indices(triangles: &[[u32; 3]]) -> String {
    let mut bytes = Vec::new();
    let mut before = 0;
    for &index in triangles.as_flattened() {
        let difference = i64::from(index) - before;
        before = i64::from(index);
        let mut rest = (difference << 1 ^ difference >> 63) as u64;
        while rest >= 0x80 {
            bytes.push(rest as u8 | 0x80);
            rest >>= 7;
        }
        bytes.push(rest as u8);
    }
    base64(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packed_positions_come_back() {
        let points = [Vec3::new(-1.0, 2.0, 0.5), Vec3::new(0.0, 2.0, 0.75), Vec3::new(1.0, 2.0, 1.0)];
        let packed = PackedPositions::of(&points);
        assert_eq!((packed.min, packed.unit), (points[0], Vec3::new(2.0, 0.0, 0.5) / 65535.0));
        let bytes = BASE64_STANDARD.decode(packed.data).unwrap();
        let numbers: Vec<u16> = bytes.chunks(2).map(|b| u16::from_le_bytes([b[0], b[1]])).collect();
        assert_eq!(numbers, [0, 0, 0, 32768, 0, 32768, 65535, 0, 65535]);
        assert_eq!(PackedPositions::of(&[]), PackedPositions::default());
    }

    #[test]
    fn indices_are_differences() {
        let bytes = BASE64_STANDARD.decode(indices(&[[0, 1, 300], [299, 2, 3]])).unwrap();
        // 0, +1, +299, -1, -297, +1
        assert_eq!(bytes, [0, 2, 0xD6, 4, 1, 0xD1, 4, 2]);
    }
}
