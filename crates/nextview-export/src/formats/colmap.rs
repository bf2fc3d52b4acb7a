//! A sparse model of COLMAP (Schönberger & Frahm 2016), as text and binary: one pinhole camera, the images,
//! and points of the cloud with the pixels that show them.

use super::out::Out;
use crate::masks::Masks;
use crate::scanned::Scanned;
use crate::view::UndistortedView;
use glam::{DVec2, DVec3};
use nextview::sensor::Depth;
use nextview_recording::{encode_color, encode_mask};
use nextview_scan::Fault;
use std::fmt::Write;

/// COLMAP's centre of the first pixel is (0.5, 0.5).
const PIXEL_CENTER: f64 = 0.5;

/// Approximate maximum number of points.
const MAX_POINTS: usize = 5000;

/// A pixel shows a point if its depth is that of the point up to this tolerance: the sum of a length in
/// metres and a share of the depth.
const TOLERANCE: (f64, f64) = (0.001, 0.005);

/// COLMAP's number of the model PINHOLE.
const PINHOLE: i32 = 1;

/// A point shown by at least two images.
struct ColmapPoint {
    position: DVec3,
    color: [u8; 3],
    /// For each image that shows the point, the index of the image and of the point within that image.
    track: Vec<(usize, usize)>,
}

/// The points shown by an image.
struct ShownPoints {
    /// The pixel of each point, and the index of the point.
    points: Vec<(DVec2, usize)>,
}

pub(super) fn write(scanned: &Scanned, out: &mut Out) -> Result<(), Fault> {
    let (width, height) = (scanned.intrinsics.width(), scanned.intrinsics.height());
    let masks = Masks::new(scanned)?;
    for view in &scanned.views {
        let name = image_name(view);
        if let Some(color) = &view.color {
            out.add(format!("images/{name}"), encode_color(color));
        }
        // The name that COLMAP expects.
        out.add(format!("masks/{name}.png"), encode_mask(width, height, &masks.of(view)?.visible));
    }
    let (points, seen) = tracks(scanned);
    out.add("sparse/0/cameras.txt", cameras_text(scanned));
    out.add("sparse/0/images.txt", images_text(scanned, &seen));
    out.add("sparse/0/points3D.txt", points_text(&points));
    out.add("sparse/0/cameras.bin", cameras_bytes(scanned));
    out.add("sparse/0/images.bin", images_bytes(scanned, &seen));
    out.add("sparse/0/points3D.bin", points_bytes(&points));
    Ok(())
}

fn image_name(view: &UndistortedView) -> String {
    view.stem() + ".png"
}

/// Some points of the cloud, and the pixels at which images show them.
fn tracks(scanned: &Scanned) -> (Vec<ColmapPoint>, Vec<ShownPoints>) {
    let stride = scanned.cloud.points.len().div_ceil(MAX_POINTS).max(1);
    let mut points = Vec::new();
    let mut seen: Vec<ShownPoints> =
        scanned.views.iter().map(|_| ShownPoints { points: Vec::new() }).collect();
    for point in scanned.cloud.points.iter().step_by(stride) {
        let pixels = scanned.views.iter().map(|view| pixel_of(view, point.position));
        let pixels: Vec<(usize, DVec2)> =
            pixels.enumerate().filter_map(|(i, pixel)| Some((i, pixel?))).collect();
        if pixels.len() < 2 {
            continue;
        }
        let mut track = Vec::new();
        for (i, pixel) in pixels {
            track.push((i, seen[i].points.len()));
            seen[i].points.push((pixel, points.len()));
        }
        points.push(ColmapPoint { position: point.position, color: point.color.unwrap_or([128; 3]), track });
    }
    (points, seen)
}

/// The pixel that shows a point; `None` if it is occluded.
fn pixel_of(view: &UndistortedView, point: DVec3) -> Option<DVec2> {
    let in_camera = view.world_from_camera().inverse().transform_point(point);
    let intrinsics = view.frame.intrinsics();
    let pixel = intrinsics.project(in_camera).filter(|pixel| intrinsics.contains(*pixel))?;
    let last = DVec2::new(f64::from(intrinsics.width() - 1), f64::from(intrinsics.height() - 1));
    let nearest = pixel.round().clamp(DVec2::ZERO, last);
    let Depth::Surface(depth) = view.frame.image().get(nearest.x as u32, nearest.y as u32) else {
        return None;
    };
    let tolerance = TOLERANCE.0 + TOLERANCE.1 * in_camera.z;
    ((f64::from(depth) - in_camera.z).abs() <= tolerance).then_some(pixel + PIXEL_CENTER)
}

/// fx, fy, cx, cy.
fn parameters(scanned: &Scanned) -> [f64; 4] {
    let (focal, center) = (scanned.intrinsics.focal(), scanned.intrinsics.center() + PIXEL_CENTER);
    [focal.x, focal.y, center.x, center.y]
}

/// Camera from world: quaternion, scalar first, and translation.
fn pose(view: &UndistortedView) -> [f64; 7] {
    let pose = view.world_from_camera().inverse();
    let (q, t) = (pose.rotation(), pose.translation());
    [q.w, q.x, q.y, q.z, t.x, t.y, t.z]
}

fn cameras_text(scanned: &Scanned) -> String {
    let [fx, fy, cx, cy] = parameters(scanned);
    let (width, height) = (scanned.intrinsics.width(), scanned.intrinsics.height());
    format!("# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n1 PINHOLE {width} {height} {fx} {fy} {cx} {cy}\n")
}

fn images_text(scanned: &Scanned, seen: &[ShownPoints]) -> String {
    let mut text =
        "# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME\n# POINTS2D[] as X, Y, POINT3D_ID\n"
            .to_owned();
    for (i, (view, seen)) in scanned.views.iter().zip(seen).enumerate() {
        let pose = pose(view).map(|number| number.to_string()).join(" ");
        let points =
            seen.points.iter().map(|(pixel, point)| format!("{} {} {}", pixel.x, pixel.y, point + 1));
        let points = points.collect::<Vec<_>>().join(" ");
        let _ = writeln!(text, "{} {pose} 1 {}\n{points}", i + 1, image_name(view)); // to memory
    }
    text
}

fn points_text(points: &[ColmapPoint]) -> String {
    let mut text = "# POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as IMAGE_ID, POINT2D_IDX\n".to_owned();
    for (i, ColmapPoint { position: p, color: [r, g, b], track }) in points.iter().enumerate() {
        let track = track.iter().map(|(image, point)| format!("{} {point}", image + 1));
        let track = track.collect::<Vec<_>>().join(" ");
        let _ = writeln!(text, "{} {} {} {} {r} {g} {b} 0 {track}", i + 1, p.x, p.y, p.z); // to memory
    }
    text
}

fn cameras_bytes(scanned: &Scanned) -> Vec<u8> {
    let mut bytes = 1_u64.to_le_bytes().to_vec();
    bytes.extend(1_u32.to_le_bytes());
    bytes.extend(PINHOLE.to_le_bytes());
    bytes.extend(u64::from(scanned.intrinsics.width()).to_le_bytes());
    bytes.extend(u64::from(scanned.intrinsics.height()).to_le_bytes());
    bytes.extend(parameters(scanned).into_iter().flat_map(f64::to_le_bytes));
    bytes
}

fn images_bytes(scanned: &Scanned, seen: &[ShownPoints]) -> Vec<u8> {
    let mut bytes = (scanned.views.len() as u64).to_le_bytes().to_vec();
    for (i, (view, seen)) in scanned.views.iter().zip(seen).enumerate() {
        bytes.extend((i as u32 + 1).to_le_bytes());
        bytes.extend(pose(view).into_iter().flat_map(f64::to_le_bytes));
        bytes.extend(1_u32.to_le_bytes());
        bytes.extend(image_name(view).into_bytes());
        bytes.push(0);
        bytes.extend((seen.points.len() as u64).to_le_bytes());
        for (pixel, point) in &seen.points {
            bytes.extend(pixel.to_array().into_iter().flat_map(f64::to_le_bytes));
            bytes.extend((*point as u64 + 1).to_le_bytes());
        }
    }
    bytes
}

fn points_bytes(points: &[ColmapPoint]) -> Vec<u8> {
    let mut bytes = (points.len() as u64).to_le_bytes().to_vec();
    for (i, ColmapPoint { position, color, track }) in points.iter().enumerate() {
        bytes.extend((i as u64 + 1).to_le_bytes());
        bytes.extend(position.to_array().into_iter().flat_map(f64::to_le_bytes));
        bytes.extend(color);
        bytes.extend(0_f64.to_le_bytes());
        bytes.extend((track.len() as u64).to_le_bytes());
        for (image, point) in track {
            bytes.extend((*image as u32 + 1).to_le_bytes());
            bytes.extend((*point as u32).to_le_bytes());
        }
    }
    bytes
}
