use nextview::sensor::{ColorImage, Frame};

/// A frame with its colours.
#[derive(Clone, Debug)]
pub struct Photo {
    /// The depth image, with the pose of the camera.
    pub frame: Frame,
    /// The colours of its pixels.
    pub color: ColorImage,
}

impl Photo {
    /// Returns the colour interpolated between the four nearest pixels, 0 to 255; outside the image, that of
    /// its border.
    pub(super) fn sample(&self, u: f64, v: f64) -> [f32; 3] {
        let clamp = |x: f64, size: u32| x.clamp(0.0, f64::from(size - 1));
        let (u, v) = (clamp(u, self.color.width()), clamp(v, self.color.height()));
        let (left, top) = (u as u32, v as u32);
        let (right, bottom) =
            ((left + 1).min(self.color.width() - 1), (top + 1).min(self.color.height() - 1));
        let (x, y) = ((u - f64::from(left)) as f32, (v - f64::from(top)) as f32);
        let corners = [(left, top), (right, top), (left, bottom), (right, bottom)];
        let weights = [(1.0 - x) * (1.0 - y), x * (1.0 - y), (1.0 - x) * y, x * y];
        let pixels = corners.map(|(u, v)| self.color.get(u, v));
        [0, 1, 2].map(|channel| (0..4).map(|i| weights[i] * f32::from(pixels[i][channel])).sum())
    }

    /// Returns the mean colour of several positions around one, so that a single pixel does not decide.
    pub(super) fn mean_around(&self, u: f64, v: f64) -> [f32; 3] {
        let offsets = [[0.0, 0.0], [1.5, 0.0], [-1.5, 0.0], [0.0, 1.5], [0.0, -1.5]];
        let colors = offsets.map(|[x, y]| self.sample(u + x, v + y));
        [0, 1, 2].map(|channel| colors.iter().map(|color| color[channel]).sum::<f32>() / 5.0)
    }
}
