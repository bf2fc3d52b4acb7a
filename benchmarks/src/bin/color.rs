//! Compares textured meshes of simulated scans with the true colours of the objects.
//!
//!     cargo build --release -p nextview-cli
//!     cargo run --release -p nextview-benchmarks --bin color -- target/release/nextview OUT
//!     cargo run --release -p nextview-benchmarks --bin color -- target/release/nextview OUT --small
//!
//! Five objects coloured by code are scanned, with and without noise, and exported as textured meshes. True
//! object, textured mesh and the scan's mesh with colours by vertex are rendered from views that the scan did
//! not take, and compared where both show the object. OUT/color.md has the table, and OUT/pictures the three
//! renderings side by side. With --small, two objects are scanned in fewer views, and the program fails if
//! textures are not clearly better.

use nextview::geometry::random::Random;
use nextview::sensor::{ColorImage, Intrinsics};
use nextview::view::generate;
use nextview_benchmarks::Outcome;
use nextview_benchmarks::painted;
use nextview_recording::{decode_color, encode_color};
use nextview_sim::camera::{Background, SimulatedCamera};
use nextview_sim::mesh::{self, Unit};
use std::ffi::OsStr;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;
use std::time::Instant;

/// Number of views for comparison, and the seed of their draw, separate from the candidates of the scans.
const VIEWS: (usize, u64) = (16, 77);

/// Maximum exposure difference of a picture, as a factor.
const EXPOSURE: f64 = 1.25;

/// Minimum gain over colours by vertex, and minimum PSNR, with `--small`, decibels.
const SMALL_GAIN: f64 = 1.5;
const SMALL_PSNR: f64 = 18.0;

/// The properties of the camera.
#[derive(Clone, Copy, PartialEq)]
enum ColorCamera {
    Exact,
    D435i,
    /// The same pictures, each with its own exposure.
    Exposures,
}

fn main() -> Outcome<()> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [program, out, rest @ ..] = &words[..] else { return Err("expected PROGRAM OUT [--small]".into()) };
    let out = Path::new(out);
    let small = rest == ["--small"];
    let (names, cameras, n_views): (&[&str], &[ColorCamera], usize) = match small {
        true => (&["mug", "package"], &[ColorCamera::D435i], 6),
        false => (&painted::NAMES, &[ColorCamera::Exact, ColorCamera::D435i, ColorCamera::Exposures], 12),
    };
    fs::create_dir_all(out.join("pictures"))?;
    let mut table = String::from(
        "| object | camera | by vertex | textured | worst view | both show it | texture | export |\n\
         |---|---|--:|--:|--:|--:|--:|--:|\n",
    );
    print!("{table}");
    for name in names {
        let object = painted::write_object(name, out)?;
        for camera in cameras {
            let folder = match camera {
                ColorCamera::Exact => out.join(format!("{name}-exact")),
                ColorCamera::D435i | ColorCamera::Exposures => out.join(format!("{name}-d435i")),
            };
            let scanned = PaintedScan { program, folder };
            match camera {
                ColorCamera::Exposures => expose(&scanned.folder.join("scan/frames/color"))?,
                _ => scanned.scan(&object, *camera, n_views)?,
            }
            let began = Instant::now();
            scanned.run(["export", "scan", "--to", "obj", "--out", "textured", "--force"])?;
            let seconds = began.elapsed().as_secs_f64();
            let picture = out.join(format!("pictures/{name}-{}", camera.word()));
            let compared = compare(&object, &scanned.folder, &picture)?;
            let mut row = format!("| {name} | {} |", camera.about());
            // The colours by vertex are those of the original pictures.
            match camera {
                ColorCamera::Exposures => row += " |",
                _ => write!(row, " {:.1} dB |", compared.by_vertex.db())?,
            }
            write!(row, " {:.1} dB | {:.1} dB |", compared.textured.db(), compared.worst)?;
            let [width, height] = compared.size;
            writeln!(row, " {:.1} % | {width} x {height} | {seconds:.1} s |", 100.0 * compared.share)?;
            print!("{row}");
            table += &row;
            let gain = compared.textured.db() - compared.by_vertex.db();
            if small && (gain < SMALL_GAIN || compared.textured.db() < SMALL_PSNR) {
                return Err(
                    format!("{name}: expected {SMALL_PSNR} dB, {SMALL_GAIN} more than by vertex").into()
                );
            }
        }
    }
    Ok(fs::write(out.join("color.md"), table)?)
}

impl ColorCamera {
    fn word(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::D435i => "d435i",
            Self::Exposures => "exposures",
        }
    }

    fn about(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::D435i => "D435i",
            Self::Exposures => "D435i, exposures differ",
        }
    }
}

/// The place of a scan and its export.
struct PaintedScan<'a> {
    program: &'a str,
    folder: PathBuf,
}

impl PaintedScan<'_> {
    fn run<S: AsRef<OsStr>>(&self, words: impl IntoIterator<Item = S>) -> Outcome<()> {
        let program = Path::new(self.program).canonicalize()?;
        let done = Command::new(program).args(words).current_dir(&self.folder).output()?;
        match done.status.success() {
            true => Ok(()),
            false => Err(String::from_utf8_lossy(&done.stderr).into_owned().into()),
        }
    }

    fn scan(&self, object: &Path, camera: ColorCamera, n_views: usize) -> Outcome<()> {
        // Leftovers of an earlier run.
        _ = fs::remove_dir_all(&self.folder);
        fs::create_dir_all(&self.folder)?;
        let object = object.canonicalize()?;
        let views = n_views.to_string();
        let mut words: Vec<&OsStr> = vec!["scan".as_ref(), object.as_ref()];
        words.extend(["--unit", "m", "--baselines", "off", "--views", &views].map(OsStr::new));
        words.extend(["--watertight", "on", "--out", "scan", "--force"].map(OsStr::new));
        if camera == ColorCamera::D435i {
            words.extend(["--noise", "d435i"].map(OsStr::new));
        }
        self.run(words)
    }
}

/// Makes pictures brighter or darker, by factors of red, green and blue whose overall product is about 1.
fn expose(folder: &Path) -> Outcome<()> {
    let mut paths: Vec<PathBuf> =
        fs::read_dir(folder)?.map(|entry| entry.map(|entry| entry.path())).collect::<Result<_, _>>()?;
    paths.sort();
    let mut random = Random::new(3, 0);
    for pair in paths.chunks(2) {
        let gains = [0, 1, 2].map(|_| EXPOSURE.powf(random.range(-1.0, 1.0)));
        for (path, gains) in pair.iter().zip([gains, gains.map(|gain| 1.0 / gain)]) {
            let image = decode_color(&fs::read(path)?, &Intrinsics::d435i())?;
            let (width, height) = (image.width(), image.height());
            let pixels = (0..height).flat_map(|v| (0..width).map(move |u| (u, v)));
            let exposed = pixels.map(|(u, v)| {
                let color = image.get(u, v);
                std::array::from_fn(|k| (gains[k] * f64::from(color[k])).round().min(255.0) as u8)
            });
            fs::write(path, encode_color(&ColorImage::new(width, height, exposed.collect())?))?;
        }
    }
    Ok(())
}

/// Comparison of two meshes of a scan with the truth.
struct Compared {
    by_vertex: ColorDifference,
    textured: ColorDifference,
    /// PSNR of the textured mesh in its worst view.
    worst: f64,
    /// Pixels in both, as a share of those that show the true object.
    share: f64,
    /// Size of the texture, pixels.
    size: [u32; 2],
}

/// Squared differences of colours, 0 to 255.
#[derive(Clone, Copy, Default)]
struct ColorDifference {
    sum: f64,
    n: f64,
}

impl ColorDifference {
    fn add(&mut self, one: [u8; 3], other: [u8; 3]) {
        let square = |k: usize| (f64::from(one[k]) - f64::from(other[k])).powi(2);
        *self = Self { sum: self.sum + square(0) + square(1) + square(2), n: self.n + 3.0 };
    }

    /// Peak signal to noise ratio.
    fn db(self) -> f64 {
        10.0 * (255.0 * 255.0 * self.n / self.sum).log10()
    }
}

fn compare(object: &Path, folder: &Path, picture: &Path) -> Outcome<Compared> {
    let camera = |path: &Path| -> Outcome<SimulatedCamera> {
        let (mesh, _) = mesh::load(path)?.to_metres(Unit::Metres)?;
        Ok(SimulatedCamera::new(Arc::new(mesh), Intrinsics::d435i(), Background::None, 10.0)?)
    };
    let truth = camera(object)?;
    let [by_vertex, textured] =
        [camera(&folder.join("scan/mesh.ply"))?, camera(&folder.join("textured/mesh.obj"))?];
    let bounds = truth.mesh().bounds();
    let views = generate::shell(bounds.center(), 0.5 * bounds.longest_side(), VIEWS.0, VIEWS.1)?;
    let mut compared = Compared {
        by_vertex: ColorDifference::default(),
        textured: ColorDifference::default(),
        worst: f64::INFINITY,
        share: 0.0,
        size: size_of(&textured)?,
    };
    let (mut n_true, mut n_both) = (0, 0);
    for view in 0..views.len() {
        let pose = views.pose(view);
        let (depth, other_depth) = (truth.render_depth(&pose)?, textured.render_depth(&pose)?);
        let no_colors = "a mesh has no colours";
        let expected = truth.color(&pose)?.ok_or(no_colors)?;
        let vertex_image = by_vertex.unlit_color(&pose)?.ok_or(no_colors)?;
        let textured_image = textured.unlit_color(&pose)?.ok_or(no_colors)?;
        let mut of_view = ColorDifference::default();
        for (i, (one, other)) in depth.iter().zip(&other_depth).enumerate() {
            n_true += usize::from(one.is_finite());
            if one.is_finite() && other.is_finite() {
                n_both += 1;
                let (u, v) = (i as u32 % expected.width(), i as u32 / expected.width());
                compared.by_vertex.add(expected.get(u, v), vertex_image.get(u, v));
                of_view.add(expected.get(u, v), textured_image.get(u, v));
            }
        }
        compared.worst = compared.worst.min(of_view.db());
        let ColorDifference { sum, n } = compared.textured;
        compared.textured = ColorDifference { sum: sum + of_view.sum, n: n + of_view.n };
        if view < 4 {
            let image = side_by_side(&[&expected, &textured_image, &vertex_image])?;
            fs::write(format!("{}-{view}.png", picture.display()), encode_color(&image))?;
        }
    }
    compared.share = f64::from(n_both as u32) / f64::from(n_true as u32);
    Ok(compared)
}

/// Width and height of the texture.
fn size_of(camera: &SimulatedCamera) -> Outcome<[u32; 2]> {
    let look = camera.mesh().appearance().ok_or("the exported mesh has no colours")?;
    let image = look.materials.first().and_then(|material| material.image.as_ref());
    image
        .map(|image| [image.width(), image.height()])
        .ok_or_else(|| "the exported mesh has no texture".into())
}

/// The part of images that is not black in the first of them, side by side.
fn side_by_side(images: &[&ColorImage]) -> Outcome<ColorImage> {
    let (width, height) = (images[0].width(), images[0].height());
    let pixels = (0..height).flat_map(|v| (0..width).map(move |u| [u, v]));
    let shown = pixels.filter(|[u, v]| images[0].get(*u, *v) != [0; 3]);
    let (low, high) = shown.fold(([u32::MAX; 2], [0; 2]), |(low, high), at| {
        ([0, 1].map(|k| at[k].min(low[k])), [0, 1].map(|k| at[k].max(high[k])))
    });
    let (wide, tall) = (high[0] + 1 - low[0], high[1] + 1 - low[1]);
    let columns = |v: u32| {
        images.iter().flat_map(move |image| (0..wide).map(move |u| image.get(low[0] + u, low[1] + v)))
    };
    Ok(ColorImage::new(wide * images.len() as u32, tall, (0..tall).flat_map(columns).collect())?)
}
