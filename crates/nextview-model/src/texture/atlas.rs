//! Drawing the texture.

use super::charts::Chart;
use super::packing::{PAD, TextureLayout};
use super::photo::Photo;
use super::sight::{PhotoSight, corners, is_touched, weights};
use super::textured_mesh::TexturedMesh;
use glam::{DVec2, DVec3};
use nextview::Error;
use nextview::sensor::ColorImage;

/// A texture being drawn.
pub(super) struct Atlas<'a> {
    layout: TextureLayout,
    triangles: &'a [[u32; 3]],
    pixels: Vec<[f32; 3]>,
    /// By pixel, its smallest barycentric weight in its triangle; minus infinity if it is not drawn yet.
    inside: Vec<f64>,
    /// In pixels of the texture; a pixel's centre has integer coordinates.
    points: Vec<DVec2>,
    texture_triangles: Vec<[u32; 3]>,
}

impl<'a> Atlas<'a> {
    pub fn new(layout: TextureLayout, triangles: &'a [[u32; 3]]) -> Self {
        let n = layout.size[0] * layout.size[1];
        Self {
            layout,
            triangles,
            pixels: vec![[128.0; 3]; n],
            inside: vec![f64::NEG_INFINITY; n],
            points: Vec::new(),
            texture_triangles: vec![[0; 3]; triangles.len()],
        }
    }

    /// Draws a chart with its corrections, by vertex, and the gain of its photo.
    pub fn draw(
        &mut self,
        i: usize,
        chart: &Chart,
        photo: &Photo,
        sight: &PhotoSight,
        corrections: &[[f32; 3]],
        gain: [f32; 3],
    ) {
        let [x, y, ..] = self.layout.rectangles[i];
        let (scale, origin) = (self.layout.scale, self.layout.origins[i]);
        let corner = DVec2::new((x + PAD) as f64, (y + PAD) as f64);
        let first = self.points.len() as u32;
        let pixel = |vertex: &u32| sight.places[*vertex as usize].map_or(origin, |place| place.pixel);
        self.points.extend(chart.vertices.iter().map(|vertex| (pixel(vertex) - origin) * scale + corner));
        for triangle in &chart.triangles {
            let slots = self.triangles[*triangle].map(|vertex| chart.slot(vertex));
            self.texture_triangles[*triangle] = slots.map(|slot| first + slot as u32);
            if corners(&sight.places, &self.triangles[*triangle]).is_none() {
                continue;
            }
            let shape = slots.map(|slot| self.points[first as usize + slot]);
            for (u, v) in self.touched(shape) {
                let at = DVec2::new(u as f64, v as f64);
                let Some(weights) = weights(shape, at) else { continue };
                let inside = weights.into_iter().fold(f64::INFINITY, f64::min);
                let index = v * self.layout.size[0] + u;
                if inside > self.inside[index] {
                    let color = footprint(photo, origin + (at - corner) / scale, scale);
                    let weights = clamped(weights);
                    self.inside[index] = inside;
                    self.pixels[index] = [0, 1, 2].map(|channel| {
                        let correction: f32 =
                            (0..3).map(|k| weights[k] * corrections[slots[k]][channel]).sum();
                        color[channel] * gain[channel] + correction
                    });
                }
            }
        }
        self.pad(self.layout.rectangles[i]);
    }

    /// Returns the pixels that lookups in a triangle may touch.
    fn touched(&self, shape: [DVec2; 3]) -> Vec<(usize, usize)> {
        let [a, b, c] = shape;
        let (low, high) = (a.min(b).min(c) - 1.0, a.max(b).max(c) + 1.0);
        let range =
            |low: f64, high: f64, size: usize| low.max(0.0) as usize..(high.max(0.0) as usize + 1).min(size);
        let columns = range(low.x, high.x, self.layout.size[0]);
        let all =
            range(low.y, high.y, self.layout.size[1]).flat_map(|v| columns.clone().map(move |u| (u, v)));
        all.filter(|(u, v)| is_touched(shape, DVec2::new(*u as f64, *v as f64))).collect()
    }

    /// Gives pixels around drawn ones their mean colour.
    fn pad(&mut self, [x, y, width, height]: [usize; 4]) {
        for _ in 0..PAD {
            let mut new = Vec::new();
            for (u, v) in (y..y + height).flat_map(|v| (x..x + width).map(move |u| (u, v))) {
                let index = v * self.layout.size[0] + u;
                if self.inside[index] > f64::NEG_INFINITY {
                    continue;
                }
                let near = (v.max(y + 1) - 1..(v + 2).min(y + height))
                    .flat_map(|v| (u.max(x + 1) - 1..(u + 2).min(x + width)).map(move |u| (u, v)))
                    .map(|(u, v)| v * self.layout.size[0] + u)
                    .filter(|index| self.inside[*index] > f64::NEG_INFINITY);
                let near: Vec<[f32; 3]> = near.map(|index| self.pixels[index]).collect();
                if !near.is_empty() {
                    let mean = |channel: usize| {
                        near.iter().map(|color| color[channel]).sum::<f32>() / near.len() as f32
                    };
                    new.push((index, [0, 1, 2].map(mean)));
                }
            }
            for (index, color) in new {
                (self.pixels[index], self.inside[index]) = (color, f64::MIN);
            }
        }
    }

    /// Draws triangles with the colours of their vertices. Between the centres of two by two pixels, lookups
    /// return exactly the mean of the corners; another pixel surrounds them.
    pub fn draw_unseen(&mut self, unseen: &[usize], colors: &[[f32; 3]]) {
        let [x, y, n_side, cell] = self.layout.unseen;
        for (i, triangle) in unseen.iter().enumerate() {
            let [a, b, c] = self.triangles[*triangle].map(|vertex| colors[vertex as usize]);
            let (x, y) = (x + i % n_side * cell, y + i / n_side * cell);
            let first = self.points.len() as u32;
            self.texture_triangles[*triangle] = [first, first + 1, first + 2];
            let at = |u: usize, v: usize| DVec2::new((x + u) as f64, (y + v) as f64);
            if cell == 1 {
                self.points.extend([at(0, 0); 3]);
                self.pixels[y * self.layout.size[0] + x] = [0, 1, 2].map(|k| (a[k] + b[k] + c[k]) / 3.0);
                continue;
            }
            self.points.extend([at(1, 1), at(2, 1), at(1, 2)]);
            let last = [0, 1, 2].map(|k| b[k] + c[k] - a[k]);
            for (u, v) in (0..cell).flat_map(|v| (0..cell).map(move |u| (u, v))) {
                let color = match (u < 2, v < 2) {
                    (true, true) => a,
                    (false, true) => b,
                    (true, false) => c,
                    (false, false) => last,
                };
                self.pixels[(y + v) * self.layout.size[0] + x + u] = color;
            }
        }
    }

    /// Returns the mesh with these vertices and the drawn texture.
    pub fn into_mesh(self, vertices: Vec<DVec3>) -> Result<TexturedMesh, Error> {
        let [width, height] = self.layout.size;
        let size = DVec2::new(width as f64, height as f64);
        let on_texture = |point: DVec2| {
            let share = (point + 0.5) / size;
            DVec2::new(share.x, 1.0 - share.y)
        };
        let pixels =
            self.pixels.into_iter().map(|color| color.map(|value| value.round().clamp(0.0, 255.0) as u8));
        Ok(TexturedMesh {
            vertices,
            triangles: self.triangles.to_vec(),
            texture_points: self.points.into_iter().map(on_texture).collect(),
            texture_triangles: self.texture_triangles,
            texture: ColorImage::new(width as u32, height as u32, pixels.collect())?,
        })
    }
}

/// Returns the mean colour of the part of a photo covered by a texture pixel.
fn footprint(photo: &Photo, center: DVec2, scale: f64) -> [f32; 3] {
    let n = (1.0 / scale).ceil() as usize;
    let offset = |k: usize| ((k as f64 + 0.5) / n as f64 - 0.5) / scale;
    let samples = (0..n * n).map(|k| photo.sample(center.x + offset(k % n), center.y + offset(k / n)));
    let sum = samples.fold([0.0; 3], |sum, next| [0, 1, 2].map(|channel| sum[channel] + next[channel]));
    sum.map(|value| value / (n * n) as f32)
}

/// Clamps weights to be non-negative with sum 1.
fn clamped(weights: [f64; 3]) -> [f32; 3] {
    let weights = weights.map(|weight| weight.max(0.0) as f32);
    let sum: f32 = weights.iter().sum();
    weights.map(|weight| weight / sum)
}
