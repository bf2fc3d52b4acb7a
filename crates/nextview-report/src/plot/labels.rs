//! The names of curves next to their ends.

use super::layout::{Plot, PlotCurve};
use crate::text::{escape, fixed};

/// Smallest vertical distance between two labels.
const STEP: f64 = 17.0;

impl Plot {
    /// The name and last value of each curve, to the right of the plot, spread out to avoid overlap.
    pub(super) fn labels(&self) -> String {
        let named = self.curves.iter().filter(|curve| !curve.label.is_empty());
        let mut ends: Vec<(&PlotCurve, usize, f64)> =
            named.filter_map(|c| c.points.last().map(|&(view, value)| (c, view, value))).collect();
        ends.sort_by(|a, b| b.2.total_cmp(&a.2));
        let mut heights: Vec<f64> = ends.iter().map(|end| self.y(end.2)).collect();
        spread(&mut heights, self.bottom());
        let right = self.right();
        let mut svg = String::new();
        for ((curve, view, value), y) in ends.into_iter().zip(heights) {
            let (x0, y0) = (self.x(view) + 6.0, self.y(value));
            svg += &format!(r#"<path class="leader" d="M{x0:.1} {y0:.1}L{} {y:.1}"/>"#, right + 3.0);
            svg += &format!(
                r#"<text class="label {}" x="{}" y="{:.1}">{} {}</text>"#,
                curve.class,
                right + 6.0,
                y + 4.5,
                escape(&curve.label),
                fixed(100.0 * value, 1)
            );
        }
        svg
    }
}

/// Spreads sorted heights to [`STEP`], above the bottom.
fn spread(heights: &mut [f64], bottom: f64) {
    for i in 1..heights.len() {
        heights[i] = heights[i].max(heights[i - 1] + STEP);
    }
    let mut limit = bottom;
    for height in heights.iter_mut().rev() {
        *height = height.min(limit);
        limit = *height - STEP;
    }
}

#[cfg(test)]
mod tests {
    use super::super::layout::TOP;
    use super::*;

    #[test]
    fn labels_keep_their_distance_and_stay_inside() {
        let bottom = 306.0;
        for mut heights in [vec![20.0, 21.0, 22.0], vec![TOP, 100.0, 101.0], vec![bottom; 3]] {
            spread(&mut heights, bottom);
            assert!(heights.windows(2).all(|w| w[1] - w[0] >= STEP - 1e-9), "{heights:?}");
            assert!(heights.iter().all(|h| (TOP..=bottom).contains(h)), "{heights:?}");
        }
    }
}
