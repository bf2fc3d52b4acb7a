//! The camera's colours: a second pass after the depth, which finds each pixel's triangle. It is not
//! optimised for speed.

use super::clip::clip;
use super::projection::ToCamera;
use super::simulated_camera::{Background, SimulatedCamera};
use crate::mesh::srgb;
use glam::{DVec2, DVec3};
use nextview::Error;
use nextview::geometry::Pose;
use nextview::sensor::ColorImage;

/// Colour of the walls of a room, and of a table.
const WALLS: [u8; 3] = [128; 3];

/// Share of light on a surface that faces up, sideways and down, as under a wide bright sky above a bright
/// ground.
const LIGHT_ABOVE: f32 = 1.0;
const LIGHT_BELOW: f32 = 0.6;

/// Tolerance outside a triangle within which a sample counts as inside, as a share of the triangle: rounding.
const MARGIN: f64 = 1e-9;

/// The triangle that a pixel shows.
#[derive(Clone, Copy)]
struct Hit {
    inverse_depth: f64,
    triangle: usize,
    /// Weights of the triangle's corners; they add up to 1.
    weights: [f64; 3],
}

impl SimulatedCamera {
    /// Returns the colour image from a pose, aligned with the depth, without noise; `None` if the mesh has no
    /// colours.
    ///
    /// The light is fixed in the world and falls from all sides, from 1 on surfaces that face up to 0.6 on
    /// those that face down. A place has the same colour in all views. Room and table are grey. Pixels that
    /// show nothing, or for which the lens model has no answer, are black. Fails if there is a room and the
    /// camera stands outside.
    pub fn color(&self, world_from_camera: &Pose) -> Result<Option<ColorImage>, Error> {
        self.colors(world_from_camera, light_on)
    }

    /// Returns the image in even light of strength 1: the colours of the mesh itself.
    pub fn unlit_color(&self, world_from_camera: &Pose) -> Result<Option<ColorImage>, Error> {
        self.colors(world_from_camera, |_| 1.0)
    }

    /// `light` is the light on a surface with this normal, which points towards the camera.
    fn colors(
        &self,
        world_from_camera: &Pose,
        light: impl Fn(DVec3) -> f32,
    ) -> Result<Option<ColorImage>, Error> {
        if self.mesh().appearance().is_none() {
            return Ok(None);
        }
        let object = self.render_object(world_from_camera)?;
        let camera = world_from_camera.translation();
        let color = |hit: &Hit| {
            let [a, b, c] = self.mesh().corners(hit.triangle);
            let normal = (b - a).cross(c - a).normalize_or_zero();
            let towards_camera = if normal.dot(camera - a) < 0.0 { -normal } else { normal };
            let reflected = self.mesh().light(hit.triangle, hit.weights).unwrap_or_default();
            srgb::to_color(reflected.map(|share| share * light(towards_camera)))
        };
        let behind = if self.background() == Background::None { [0; 3] } else { WALLS };
        let pixels = self.hits(world_from_camera).into_iter().zip(object).map(|(hit, depth)| match hit {
            Some(hit) if depth.is_finite() => color(&hit),
            _ if depth.is_nan() => [0; 3],
            _ => behind,
        });
        let (width, height) = (self.intrinsics().width(), self.intrinsics().height());
        ColorImage::new(width, height, pixels.collect()).map(Some)
    }

    /// The nearest triangle at every pixel; the first if several are equally near.
    fn hits(&self, world_from_camera: &Pose) -> Vec<Option<Hit>> {
        let to_camera = ToCamera::new(world_from_camera);
        let samples: Vec<DVec2> = self.samples().ideal_points().collect();
        let grid = SampleGrid::new(&samples);
        let mut hits: Vec<Option<Hit>> = vec![None; samples.len()];
        for triangle in 0..self.mesh().triangles().len() {
            let corners = self.mesh().corners(triangle).map(|corner| to_camera.point(corner));
            let (polygon, n) = clip(corners);
            if n == 0 {
                continue;
            }
            let ideal = polygon[..n].iter().map(|corner| corner.truncate() / corner.z);
            let (low, high) =
                ideal.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
            let facet = Facet::new(corners);
            for pixel in grid.near(low, high) {
                let Some((inverse_depth, weights)) = facet.meet(samples[pixel]) else { continue };
                if hits[pixel].is_none_or(|hit| inverse_depth > hit.inverse_depth) {
                    hits[pixel] = Some(Hit { inverse_depth, triangle, weights });
                }
            }
        }
        hits
    }
}

/// The light on a surface with this normal.
fn light_on(normal: DVec3) -> f32 {
    let up = 0.5 * (1.0 + normal.z as f32);
    LIGHT_BELOW + (LIGHT_ABOVE - LIGHT_BELOW) * up
}

/// A triangle in camera coordinates, ready for intersection with rays from the origin. At the ray (x, y, 1),
/// the volumes spanned with two corners each are proportional to the weights of the third.
struct Facet {
    sides: [DVec3; 3],
    volume: f64,
}

impl Facet {
    fn new([a, b, c]: [DVec3; 3]) -> Self {
        Self { sides: [b.cross(c), c.cross(a), a.cross(b)], volume: a.dot(b.cross(c)) }
    }

    /// 1 / depth and corner weights at the intersection with the ray through a point of the plane z = 1.
    fn meet(&self, ideal: DVec2) -> Option<(f64, [f64; 3])> {
        let shares = self.sides.map(|side| side.dot(ideal.extend(1.0)) / self.volume);
        let inverse_depth: f64 = shares.iter().sum();
        let is_met = inverse_depth > 0.0 && shares.iter().all(|share| *share >= -MARGIN * inverse_depth);
        let weights = || shares.map(|share| (share / inverse_depth).clamp(0.0, 1.0));
        (is_met && inverse_depth.is_finite()).then(|| (inverse_depth, weights()))
    }
}

/// The samples in cells of the plane z = 1: finds those in a box quickly for any lens.
struct SampleGrid {
    low: DVec2,
    cell: DVec2,
    n: usize,
    cells: Vec<Vec<usize>>,
}

impl SampleGrid {
    fn new(samples: &[DVec2]) -> Self {
        let known = samples.iter().filter(|sample| sample.is_finite());
        let (low, high) =
            known.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(l, h), p| (l.min(*p), h.max(*p)));
        let n = ((samples.len() as f64).sqrt() / 2.0).ceil() as usize;
        let cell = ((high - low) / n as f64).max(DVec2::splat(f64::MIN_POSITIVE));
        let mut grid = Self { low, cell, n, cells: vec![Vec::new(); n * n] };
        for (i, sample) in samples.iter().enumerate().filter(|(_, sample)| sample.is_finite()) {
            let [column, row] = grid.place(*sample);
            grid.cells[row * n + column].push(i);
        }
        grid
    }

    /// The cell of a point; points outside get a cell at the border.
    fn place(&self, point: DVec2) -> [usize; 2] {
        let at = (point - self.low) / self.cell;
        [at.x, at.y].map(|x| (x.max(0.0) as usize).min(self.n - 1))
    }

    /// The samples in a box and some around it.
    fn near(&self, low: DVec2, high: DVec2) -> impl Iterator<Item = usize> + '_ {
        let tiny = 1e-6 * self.cell;
        let ([left, top], [right, bottom]) = (self.place(low - tiny), self.place(high + tiny));
        (top..=bottom).flat_map(move |row| {
            self.cells[row * self.n + left..=row * self.n + right].iter().flatten().copied()
        })
    }
}
