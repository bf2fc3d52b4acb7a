//! A picture of the model on its table: a small drawing without a graphics card.

use super::color::Rgb;
use super::png_file::png_file;
use super::shown::ShownModel;
use base64::prelude::{BASE64_STANDARD, Engine};
use glam::{DMat3, DQuat, DVec2, DVec3};

const WIDTH: usize = 300;
const HEIGHT: usize = 240;

/// Free space around the model, pixels.
const MARGIN: f64 = 24.0;

/// Elevation of the eye above the table, and its azimuth, radians.
const EYE: (f64, f64) = (0.45, 0.6);

const SKY: Rgb = [246, 248, 250];
const TABLE: Rgb = [221, 226, 231];
const SURFACE: Rgb = [190, 202, 216];
/// Colour of the inside of open parts, where nothing was seen.
const UNSEEN: Rgb = [232, 146, 60];

/// Share of ambient light.
const AMBIENT: f64 = 0.35;

/// The `figure` element of a model on a table with the normal `up`, placed so that its current direction
/// `down` points into the table. Unseen parts are open, and their inside is orange.
pub(super) fn picture(model: &ShownModel, up: DVec3, down: DVec3, caption: &str) -> String {
    let vertices: Vec<DVec3> = model.vertices.iter().map(|vertex| vertex.position).collect();
    let pixels = Drawing::of(&vertices, &model.triangles, up, down).pixels;
    let png = png_file([WIDTH as u32, HEIGHT as u32], pixels.as_flattened(), None, png::Compression::High);
    format!(
        r#"<figure><img width="{WIDTH}" height="{HEIGHT}" alt="The object in the {caption}; unseen surface is orange" src="data:image/png;base64,{}"><figcaption>{caption}</figcaption></figure>"#,
        BASE64_STANDARD.encode(png)
    )
}

/// Pixels with their depths.
struct Drawing {
    pixels: Vec<Rgb>,
    depths: Vec<f64>,
}

impl Drawing {
    fn of(vertices: &[DVec3], triangles: &[[u32; 3]], up: DVec3, down: DVec3) -> Self {
        // Upright, then in the eye's frame: x to the right, y down, z away.
        let laid = DQuat::from_rotation_arc(down.normalize_or(-up), -up);
        let upright = DQuat::from_rotation_arc(up, DVec3::Z) * laid;
        let (height, around) = EYE;
        let eye_from_upright =
            DMat3::from_rotation_x(height - 0.5 * std::f64::consts::PI) * DMat3::from_rotation_z(around);
        let eye_from_upright = DMat3::from_diagonal(DVec3::new(1.0, -1.0, -1.0)) * eye_from_upright;
        let placed: Vec<DVec3> = vertices.iter().map(|vertex| upright * *vertex).collect();
        let low = placed.iter().copied().fold(DVec3::INFINITY, DVec3::min);
        let high = placed.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
        let mut drawing =
            Self { pixels: vec![SKY; WIDTH * HEIGHT], depths: vec![f64::INFINITY; WIDTH * HEIGHT] };
        if triangles.is_empty() {
            return drawing;
        }
        let reach = 0.6 * (high - low).truncate().length();
        let (middle, floor) = (0.5 * (low + high), low.z);
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|(x, y)| DVec3::new(middle.x + reach * x, middle.y + reach * y, floor));
        let seen = |point: DVec3| eye_from_upright * (point - middle);
        let extent = placed.iter().chain(&corners).map(|point| seen(*point).truncate());
        let (left, right) = extent.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), point| {
            (low.min(point), high.max(point))
        });
        let size = DVec2::new(WIDTH as f64, HEIGHT as f64);
        let scale = ((size - 2.0 * MARGIN) / (right - left)).min_element();
        let offset = 0.5 * size - 0.5 * scale * (left + right);
        let pixel = |point: DVec3| {
            let point = seen(point);
            (scale * point.truncate() + offset).extend(point.z)
        };
        let [a, b, c, d] = corners.map(pixel);
        drawing.fill([a, b, c], TABLE);
        drawing.fill([a, c, d], TABLE);
        let light = DVec3::new(-0.4, -0.7, -0.6).normalize();
        for triangle in triangles {
            let corners = triangle.map(|i| placed[i as usize]);
            let [a, b, c] = corners.map(seen);
            let normal = (b - a).cross(c - a).normalize_or_zero();
            // A triangle that faces the eye is the surface; one that faces away shows the inside of an open
            // part.
            let (color, normal) = if normal.z < 0.0 { (SURFACE, normal) } else { (UNSEEN, -normal) };
            let shade = AMBIENT + (1.0 - AMBIENT) * normal.dot(light).max(0.0);
            drawing.fill(corners.map(pixel), color.map(|c| (f64::from(c) * shade.min(1.0)).round() as u8));
        }
        drawing
    }

    /// Fills a triangle, with x and y in pixels.
    fn fill(&mut self, [a, b, c]: [DVec3; 3], color: Rgb) {
        let area = (b - a).truncate().perp_dot((c - a).truncate());
        if area == 0.0 {
            return;
        }
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        let range = |low: f64, high: f64, n: usize| {
            low.floor().max(0.0) as usize..(high.ceil().max(0.0) as usize).min(n)
        };
        for y in range(low.y, high.y, HEIGHT) {
            for x in range(low.x, high.x, WIDTH) {
                let at = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
                let weight = |from: DVec3, to: DVec3| {
                    (to.truncate() - from.truncate()).perp_dot(at - from.truncate()) / area
                };
                let weights = DVec3::new(weight(b, c), weight(c, a), weight(a, b));
                let depth = weights.dot(DVec3::new(a.z, b.z, c.z));
                let i = y * WIDTH + x;
                if weights.min_element() >= 0.0 && depth < self.depths[i] {
                    (self.depths[i], self.pixels[i]) = (depth, color);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cube without its underside, counter-clockwise seen from outside.
    fn open_cube() -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let corner = |i: u32| DVec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64);
        let sides = [[0, 1, 5, 4], [1, 3, 7, 5], [3, 2, 6, 7], [2, 0, 4, 6], [4, 5, 7, 6]];
        let triangles = sides.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]);
        ((0..8).map(corner).collect(), triangles.collect())
    }

    fn is_orange([red, _, blue]: &Rgb) -> bool {
        2 * u32::from(*red) > 3 * u32::from(*blue)
    }

    #[test]
    fn the_open_side_shows_when_the_object_is_turned() {
        let (vertices, triangles) = open_cube();
        let n_orange = |down: DVec3| {
            let drawing = Drawing::of(&vertices, &triangles, DVec3::Z, down);
            drawing.pixels.iter().filter(|pixel| is_orange(pixel)).count()
        };
        assert_eq!(n_orange(DVec3::NEG_Z), 0);
        assert!(n_orange(DVec3::Z) > 2000, "{}", n_orange(DVec3::Z));
    }

    #[test]
    fn nothing_is_a_picture_too() {
        let drawing = Drawing::of(&[], &[], DVec3::Z, DVec3::Z);
        assert!(drawing.pixels.iter().all(|pixel| *pixel == SKY));
    }
}
