//! Coloured objects made by code: references for textured meshes.

mod fine;
mod package;

pub use package::write_package;

use fine::fine;
use glam::DVec3;
use nextview::surface::CloudPoint;
use nextview_model::write_mesh;
use nextview_sim::builtin;
use nextview_sim::mesh::TriangleMesh;
use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};

/// Maximum edge length of a mesh with vertex colours, metres, which is the resolution of the patterns.
const LONGEST_EDGE: f64 = 0.0008;

/// Names of all objects.
pub const NAMES: [&str; 5] = ["mug", "teapot", "bracket", "torus-knot", "package"];

/// Writes the mesh file of an object into a folder, in metres: a PLY with coloured vertices or, for the
/// package, an OBJ with an image.
pub fn write_object(name: &str, folder: &Path) -> Result<PathBuf, Box<dyn Error>> {
    let paint: fn(DVec3) -> [f64; 3] = match name {
        "mug" => dots,
        "teapot" => marble,
        "bracket" => checks,
        "torus-knot" => rings,
        "package" => return write_package(folder),
        _ => return Err(format!("{name:?} is not one of {NAMES:?}").into()),
    };
    let mesh = fine(&builtin::by_name(name).ok_or("no such built-in object")?, LONGEST_EDGE)?;
    let path = folder.join(format!("{name}.ply"));
    let color = |point: DVec3| Some(paint(point).map(|share| (255.0 * share.clamp(0.0, 1.0)).round() as u8));
    write_ply(&path, &mesh, color)?;
    Ok(path)
}

fn write_ply(
    path: &Path,
    mesh: &TriangleMesh,
    color: impl Fn(DVec3) -> Option<[u8; 3]>,
) -> Result<(), Box<dyn Error>> {
    let point = |at: &DVec3| CloudPoint { color: color(*at), ..(*at).into() };
    let points: Vec<CloudPoint> = mesh.vertices().iter().map(point).collect();
    let mut bytes = Vec::new();
    write_mesh(&mut bytes, &points, None, mesh.triangles())?;
    Ok(fs::write(path, bytes)?)
}

/// Round dots of many colours, 18 mm apart, on white.
fn dots(at: DVec3) -> [f64; 3] {
    let cell = (at / 0.018).round();
    let is_dot = (at / 0.018 - cell).length() < 0.38;
    let hue = (cell.x * 0.37 + cell.y * 0.61 + cell.z * 0.23).rem_euclid(1.0);
    if is_dot { of_hue(hue) } else { [0.93, 0.91, 0.86] }
}

/// Veins of 6 to 30 mm, blue on cream.
fn marble(at: DVec3) -> [f64; 3] {
    let p = at * 200.0;
    let bend = (0.9 * p.y).sin() + 0.7 * (1.3 * p.z + p.x).sin() + 0.4 * (2.9 * p.x - p.y).sin();
    let vein = (0.5 + 0.5 * (0.8 * p.x + 2.0 * bend).sin()).powi(2);
    mixed([0.94, 0.90, 0.80], [0.10, 0.18, 0.45], vein)
}

/// Cubes of 10 mm, alternately dark and in a colour that changes along the object.
fn checks(at: DVec3) -> [f64; 3] {
    let cell = ((at + 0.0031) / 0.01).floor();
    let is_dark = (cell.x + cell.y + cell.z).rem_euclid(2.0) == 0.0;
    if is_dark { [0.12, 0.12, 0.14] } else { of_hue((4.0 * at.x + 3.0 * at.y + 0.5).rem_euclid(1.0)) }
}

/// Fine lines of 5 mm on colours that change smoothly.
fn rings(at: DVec3) -> [f64; 3] {
    let base = of_hue((3.0 * at.x + 2.0 * at.z).rem_euclid(1.0));
    let line = (0.5 + 0.5 * (at.z * std::f64::consts::TAU / 0.005).sin()).powi(4);
    mixed(base, [0.05, 0.05, 0.08], line)
}

/// A colour with this hue, 0 to 1, neither black nor white.
fn of_hue(hue: f64) -> [f64; 3] {
    [0.0, 1.0 / 3.0, 2.0 / 3.0].map(|offset| 0.5 + 0.4 * (std::f64::consts::TAU * (hue - offset)).cos())
}

fn mixed(from: [f64; 3], to: [f64; 3], share: f64) -> [f64; 3] {
    std::array::from_fn(|k| from[k] + share * (to[k] - from[k]))
}
