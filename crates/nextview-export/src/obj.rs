//! The mesh as an OBJ file.

use nextview_scan::SavedModel;
use std::fmt::Write;

/// The mesh with its colours behind the coordinates of each vertex, metres.
pub(crate) fn text(mesh: &SavedModel) -> String {
    let mut text = String::new();
    for point in &mesh.points {
        let [x, y, z] = point.position.to_array();
        let _ = write!(text, "v {x} {y} {z}"); // to memory, here and below
        if let Some(color) = point.color {
            let [r, g, b] = color.map(|of| f64::from(of) / 255.0);
            let _ = write!(text, " {r:.4} {g:.4} {b:.4}");
        }
        text.push('\n');
    }
    for [a, b, c] in mesh.triangles.iter().map(|triangle| triangle.map(|i| i + 1)) {
        let _ = writeln!(text, "f {a} {b} {c}");
    }
    text
}
