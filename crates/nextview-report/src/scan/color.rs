//! Colours for numbers and for views.

/// An sRGB colour.
pub type Rgb = [u8; 3];

/// Depth from near to far. Lightness decreases throughout, so the order survives black-and-white printing,
/// and starts below white, which stands for "nothing there".
pub const DEPTH: [Rgb; 4] = [[252, 205, 97], [226, 122, 80], [138, 50, 108], [34, 18, 72]];

/// Views from first to last: hues in spectral order, all readable on white and on near-black.
pub const VIEWS: [Rgb; 6] =
    [[58, 104, 214], [26, 152, 178], [58, 164, 84], [196, 158, 34], [222, 104, 44], [196, 46, 96]];

/// Returns the colour at `t` in 0..=1 on a ramp of evenly spaced stops.
pub fn color(stops: &[Rgb], t: f64) -> Rgb {
    let at = t.clamp(0.0, 1.0) * (stops.len() - 1) as f64;
    let low = (at as usize).min(stops.len() - 2);
    let mix = |a: u8, b: u8| (a as f64 + (b as f64 - a as f64) * (at - low as f64)).round() as u8;
    std::array::from_fn(|c| mix(stops[low][c], stops[low + 1][c]))
}

/// Returns the colour of view `i` of `n` views.
pub fn view(i: usize, n: usize) -> Rgb {
    color(&VIEWS, i as f64 / (n.max(2) - 1) as f64)
}

/// The colour in CSS notation.
pub fn css([r, g, b]: Rgb) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ramps_hit_their_stops_and_take_any_number() {
        assert_eq!(color(&DEPTH, 0.0), DEPTH[0]);
        assert_eq!(color(&DEPTH, 1.0), DEPTH[3]);
        assert_eq!(color(&DEPTH, 7.0), DEPTH[3]);
        assert_eq!(view(0, 1), VIEWS[0]);
        assert_eq!(view(9, 10), VIEWS[5]);
        assert_eq!(css([0, 171, 255]), "#00abff");
    }

    #[test]
    fn depth_gets_darker_with_distance() {
        let lightness = |i| {
            let [r, g, b] = color(&DEPTH, i as f64 / 50.0);
            299 * r as u32 + 587 * g as u32 + 114 * b as u32
        };
        assert!((0..50).all(|i| lightness(i + 1) < lightness(i)));
    }
}
