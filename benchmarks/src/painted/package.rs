//! A printed cardboard box.

use nextview::sensor::ColorImage;
use nextview_recording::encode_color;
use std::error::Error;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

/// Size of the box, metres.
const SIZE: [f64; 3] = [0.12, 0.07, 0.16];

/// Width of a side's print, pixels; six of them lie side by side in the image.
const SIDE: u32 = 512;

/// Writes `package.obj` with its material and image.
pub fn write_package(folder: &Path) -> Result<PathBuf, Box<dyn Error>> {
    let path = folder.join("package.obj");
    let mut obj = String::from("mtllib package.mtl\nusemtl print\n");
    let mut n = 0;
    for axis in 0..3 {
        for side in [0.0, 1.0] {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            // Counter-clockwise seen from outside.
            let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
            for [s, t] in corners.map(|[s, t]| if side == 0.0 { [t, s] } else { [s, t] }) {
                let mut at = [0.0; 3];
                (at[axis], at[u], at[v]) = (side * SIZE[axis], s * SIZE[u], t * SIZE[v]);
                let print = (2 * axis) as f64 + side;
                writeln!(obj, "v {} {} {}", at[0] - 0.5 * SIZE[0], at[1] - 0.5 * SIZE[1], at[2])?;
                writeln!(obj, "vt {:.6} {t:.6}", (print + s) / 6.0)?;
            }
            let corner = |k: usize| format!("{0}/{0}", n + k);
            writeln!(obj, "f {} {} {} {}", corner(1), corner(2), corner(3), corner(4))?;
            n += 4;
        }
    }
    fs::write(&path, obj)?;
    fs::write(folder.join("package.mtl"), "newmtl print\nKd 1 1 1\nmap_Kd package.png\n")?;
    let pixels = (0..SIDE).flat_map(|v| (0..6 * SIDE).map(move |u| print(u / SIDE, u % SIDE, v)));
    let image = ColorImage::new(6 * SIDE, SIDE, pixels.collect())?;
    fs::write(folder.join("package.png"), encode_color(&image))?;
    Ok(path)
}

/// A pixel of a side: a frame, a disc, bars of a code, and lines like text.
fn print(side: u32, u: u32, v: u32) -> [u8; 3] {
    const GROUND: [[u8; 3]; 6] =
        [[222, 186, 60], [60, 130, 190], [210, 80, 70], [80, 160, 90], [235, 230, 220], [120, 90, 160]];
    let ground = GROUND[side as usize];
    let ink = ground.map(|value| if value > 128 { value / 5 } else { 255 - value / 4 });
    let is_frame = [u, v].iter().any(|x| (20..30).contains(x) || (482..492).contains(x));
    let (x, y) = (i64::from(u) - 150, i64::from(v) - 160);
    let is_disc = (70 * 70..95 * 95).contains(&(x * x + y * y)) || x * x + y * y < 40 * 40;
    let is_bar = (290..460).contains(&u) && (70..230).contains(&v) && (u * u / 97 + u / 5).is_multiple_of(3);
    let word = (u / 24 + 7 * (v / 36) + side) % 6;
    let is_text = (290..470).contains(&v)
        && (60..460).contains(&u)
        && v % 36 < 16
        && word > 0
        && !(u / 4).is_multiple_of(3);
    if is_frame || is_disc || is_bar || is_text { ink } else { ground }
}
