use crate::messages::{Bytes, Header, PointCloud2, PointField};
use glam::DVec3;

/// The code of a 32-bit float in `sensor_msgs/msg/PointField`.
const FLOAT32: u8 = 7;

/// Bytes of a point.
const STEP: usize = 12;

/// Maximum number of points: larger messages do not pass best-effort networks whole.
const MAX_POINTS: usize = 200_000;

/// Points as x, y, z; if there are too many, every second, third, ... one.
pub fn message(points: &[DVec3], frame: &str) -> PointCloud2 {
    let points: Vec<&DVec3> = points.iter().step_by(points.len().div_ceil(MAX_POINTS).max(1)).collect();
    let field = |(i, name): (u32, &str)| PointField {
        name: name.to_owned(),
        offset: 4 * i,
        datatype: FLOAT32,
        count: 1,
    };
    let bytes = points.iter().flat_map(|point| point.to_array()).flat_map(|x| (x as f32).to_le_bytes());
    PointCloud2 {
        header: Header::of(frame),
        height: 1,
        width: points.len() as u32,
        fields: (0..).zip(["x", "y", "z"]).map(field).collect(),
        is_bigendian: false,
        point_step: STEP as u32,
        row_step: (STEP * points.len()) as u32,
        data: Bytes(bytes.collect()),
        is_dense: true,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_is_three_floats_and_there_are_not_too_many() {
        let cloud = message(&[DVec3::new(1.0, 2.0, 3.0)], "map");
        assert_eq!(cloud.data.0, [1.0_f32, 2.0, 3.0].map(f32::to_le_bytes).concat());
        let many = message(&vec![DVec3::ZERO; 500_000], "map");
        assert!(many.width as usize <= MAX_POINTS && many.row_step as usize == many.data.0.len());
    }
}
