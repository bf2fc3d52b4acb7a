//! The cloud as a binary file of the Point Cloud Library, version 0.7.

use super::out::Out;
use crate::scanned::Scanned;

pub(super) fn write(scanned: &Scanned, out: &mut Out) {
    let points = &scanned.cloud.points;
    let has_normals = points.iter().any(|point| point.normal.is_some());
    let has_colors = points.iter().any(|point| point.color.is_some());
    let mut fields = vec!["x", "y", "z"];
    if has_normals {
        fields.extend(["normal_x", "normal_y", "normal_z"]);
    }
    if has_colors {
        fields.push("rgb");
    }
    let column = |word: &str| [word].repeat(fields.len()).join(" ");
    let n = points.len();
    let head = format!(
        "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS {}\nSIZE {}\nTYPE {}\nCOUNT {}\nWIDTH {n}\n\
         HEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {n}\nDATA binary\n",
        fields.join(" "),
        column("4"),
        column("F"),
        column("1"),
    );
    let mut bytes = head.into_bytes();
    let put = |bytes: &mut Vec<u8>, value: f64| bytes.extend((value as f32).to_le_bytes());
    for point in points {
        point.position.to_array().iter().for_each(|x| put(&mut bytes, *x));
        if has_normals {
            // PCL's mark for a missing normal.
            let normal = point.normal.map_or([f64::NAN; 3], |normal| normal.to_array());
            normal.iter().for_each(|x| put(&mut bytes, *x));
        }
        if has_colors {
            // Blue first: the number 0xRRGGBB in little-endian format, read as a float.
            let [r, g, b] = point.color.unwrap_or_default();
            bytes.extend([b, g, r, 0]);
        }
    }
    out.add("cloud.pcd", bytes);
}
