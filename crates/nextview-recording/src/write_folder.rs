//! Writes frames as a folder in our own format, for [`Recording::open`](crate::Recording::open).

use crate::{encode_color, encode_depth, encode_mask};
use nextview::geometry::Pose;
use nextview::sensor::{ColorImage, Depth, DepthImage, Distortion, Frame, Intrinsics};
use std::fmt::Write;

/// A frame and its number in the folder.
#[derive(Clone, Copy, Debug)]
pub struct NumberedFrame<'a> {
    /// Number used in the names of its images.
    pub number: usize,
    /// The frame, with the pose to write.
    pub frame: &'a Frame,
}

/// Metres per unit of the images if all depths fit: finer than the resolution of any camera.
const FINE_UNIT: f64 = 0.0001;

/// Writes the frames of one camera: `intrinsics.txt`, `poses.csv`, `depth/`, and `color/` for frames with
/// colours. `mask/` marks the pixels without return up to the camera's range, if there are any. Depths are
/// rounded to a tenth of a millimetre, or, beyond 6.5 m, to a unit that fits 65535 units.
///
/// `color` is called for the image of each frame by index. `write` receives every file, with a name relative
/// to the folder and separated by `/`. Nothing is written without frames. Fails only if one of the two does.
pub fn write_folder<E>(
    frames: &[NumberedFrame<'_>],
    mut color: impl FnMut(usize) -> Result<Option<ColorImage>, E>,
    mut write: impl FnMut(&str, Vec<u8>) -> Result<(), E>,
) -> Result<(), E> {
    let Some(first) = frames.first() else { return Ok(()) };
    let farthest = frames.iter().flat_map(|of| depths(of.frame.image())).fold(0.0, f64::max);
    let unit = FINE_UNIT.max(farthest / f64::from(u16::MAX));
    write("intrinsics.txt", intrinsics_text(first.frame.intrinsics(), unit).into_bytes())?;
    write("poses.csv", poses_text(frames).into_bytes())?;
    let has_free = frames.iter().any(|of| of.frame.image().pixels().any(|pixel| pixel == Depth::Beyond));
    for (i, NumberedFrame { number, frame }) in frames.iter().enumerate() {
        let image = frame.image();
        write(&format!("depth/{number:03}.png"), encode_depth(image, unit))?;
        if has_free {
            let mask: Vec<bool> = image.pixels().map(|pixel| pixel != Depth::Beyond).collect();
            write(&format!("mask/{number:03}.png"), encode_mask(image.width(), image.height(), &mask))?;
        }
        if let Some(color) = color(i)? {
            write(&format!("color/{number:03}.png"), encode_color(&color))?;
        }
    }
    Ok(())
}

fn depths(image: &DepthImage) -> impl Iterator<Item = f64> + '_ {
    image.pixels().filter_map(|pixel| match pixel {
        Depth::Surface(depth) => Some(f64::from(depth)),
        Depth::Missing | Depth::Beyond => None,
    })
}

/// The content of `intrinsics.txt`, for images in units of this many metres.
pub fn intrinsics_text(intrinsics: &Intrinsics, depth_unit: f64) -> String {
    let (focal, center) = (intrinsics.focal(), intrinsics.center());
    let mut text = format!(
        "width {}\nheight {}\nfx {}\nfy {}\ncx {}\ncy {}\ndepth_unit_m {depth_unit}\n",
        intrinsics.width(),
        intrinsics.height(),
        focal.x,
        focal.y,
        center.x,
        center.y
    );
    let model = match intrinsics.distortion() {
        Distortion::None => return text,
        Distortion::BrownConrady(_) => "brown-conrady",
        Distortion::InverseBrownConrady(_) => "inverse-brown-conrady",
    };
    let [k1, k2, p1, p2, k3] = intrinsics.distortion().coefficients();
    let _ = writeln!(text, "distortion {model} {k1} {k2} {p1} {p2} {k3}"); // to memory
    text
}

fn poses_text(frames: &[NumberedFrame<'_>]) -> String {
    let mut text = "frame".to_owned();
    (0..12).for_each(|i| _ = write!(text, ",world_from_camera_{}{}", i / 4, i % 4));
    text.push('\n');
    for NumberedFrame { number, frame } in frames {
        let _ = write!(text, "{number}");
        rows(&frame.world_from_camera()).iter().for_each(|entry| _ = write!(text, ",{entry}"));
        text.push('\n');
    }
    text
}

/// The first three rows of the matrix, by rows.
fn rows(pose: &Pose) -> [f64; 12] {
    let (r, t) = (pose.rotation_matrix(), pose.translation());
    std::array::from_fn(|i| if i % 4 == 3 { t[i / 4] } else { r.col(i % 4)[i / 4] })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ReadOptions, Recording};
    use glam::{DQuat, DVec2, DVec3};
    use std::convert::Infallible;
    use std::fs;

    #[test]
    fn what_is_written_reads_back() {
        let folder = std::env::temp_dir().join(format!("nextview-write-folder-{}", std::process::id()));
        let distortion = Distortion::InverseBrownConrady([0.1, -0.2, 0.001, 0.002, 0.05]);
        let camera = Intrinsics::pinhole(4, 3, DVec2::new(5.25, 5.5), DVec2::new(1.5, 1.0)).unwrap();
        let camera = camera.with_distortion(distortion).unwrap();
        let frame = |farthest: f32| {
            let mut depth = vec![0.12344_f32; 12];
            (depth[3], depth[5], depth[7]) = (f32::NAN, f32::INFINITY, farthest);
            let rotation = DQuat::from_euler(glam::EulerRot::XYZ, 0.3, -1.2, 2.0);
            let pose = Pose::new(rotation, DVec3::new(0.1, f64::from(farthest), -0.3)).unwrap();
            Frame::new(DepthImage::from_metres(4, 3, depth).unwrap(), camera, pose, 10.0).unwrap()
        };
        for farthest in [2.5, 9.0] {
            let frames = [frame(0.2), frame(farthest)];
            let numbered = [3, 12].iter().zip(&frames).map(|(n, frame)| NumberedFrame { number: *n, frame });
            let color = ColorImage::new(4, 3, (0..12).map(|i| [i, 2 * i, 255 - i]).collect()).unwrap();
            let color_of = |i: usize| Ok::<_, Infallible>((i == 1).then(|| color.clone()));
            let write = |name: &str, bytes: Vec<u8>| {
                fs::create_dir_all(folder.join(name).parent().unwrap()).unwrap();
                fs::write(folder.join(name), bytes).unwrap();
                Ok(())
            };
            write_folder(&numbered.collect::<Vec<_>>(), color_of, write).unwrap();

            let read = Recording::open(&folder, &ReadOptions::default()).unwrap();
            assert_eq!(read.intrinsics, camera);
            let names: Vec<&str> = read.frames.iter().map(|frame| frame.name.as_str()).collect();
            assert_eq!(names, ["frame 3", "frame 12"]);
            for (read, written) in read.frames.iter().zip(&frames) {
                let (a, b) = (read.world_from_camera, written.world_from_camera());
                assert!(
                    a.translation() == b.translation() && a.rotation().angle_between(b.rotation()) < 1e-7
                );
                for (a, b) in read.load().unwrap().image().pixels().zip(written.image().pixels()) {
                    match (a, b) {
                        (Depth::Surface(a), Depth::Surface(b)) => assert!((a - b).abs() < 8e-5, "{a} {b}"),
                        _ => assert_eq!(a, b),
                    }
                }
            }
            assert_eq!(read.frames[0].load_color().unwrap(), None);
            assert_eq!(read.frames[1].load_color().unwrap(), Some(color));
            fs::remove_dir_all(&folder).unwrap();
        }
    }
}
