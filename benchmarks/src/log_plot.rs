//! Time and memory against a size, both axes logarithmic, as an SVG drawing.

use std::fmt::Write;

/// A measurement at one size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measurement {
    /// The size.
    pub size: f64,
    /// Milliseconds.
    pub ms: f64,
    /// Megabytes.
    pub mb: f64,
}

/// One of several drawings side by side.
#[derive(Clone, Debug, PartialEq)]
pub struct Panel {
    /// Title of the drawing.
    pub title: String,
    /// Label of the size axis.
    pub x_label: String,
    /// Points ascending by size; all numbers are positive.
    pub points: Vec<Measurement>,
}

/// Returns the slope of a value against the size in logarithms, by least squares over the upper half of the
/// points: the exponent of growth.
pub fn exponent(points: &[Measurement], value: impl Fn(&Measurement) -> f64) -> f64 {
    let upper = &points[points.len() / 2..];
    let logs: Vec<(f64, f64)> = upper.iter().map(|point| (point.size.ln(), value(point).ln())).collect();
    let n = logs.len() as f64;
    let (mean_x, mean_y) =
        (logs.iter().map(|p| p.0).sum::<f64>() / n, logs.iter().map(|p| p.1).sum::<f64>() / n);
    let covariance: f64 = logs.iter().map(|p| (p.0 - mean_x) * (p.1 - mean_y)).sum();
    covariance / logs.iter().map(|p| (p.0 - mean_x).powi(2)).sum::<f64>()
}

const PLOT: [f64; 2] = [240.0, 240.0];
const PANEL_WIDTH: f64 = 330.0;
const LEFT: f64 = 52.0;
const TOP: f64 = 36.0;
const HEIGHT: f64 = 340.0;

/// Draws the panels side by side, on white.
pub fn draw(panels: &[Panel]) -> String {
    let width = PANEL_WIDTH * panels.len() as f64;
    let mut svg = format!(
        concat!(
            r##"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {w} {h}" font-family="sans-serif" font-size="11">"##,
            r##"<rect width="{w}" height="{h}" fill="#fff"/>"##
        ),
        w = width,
        h = HEIGHT
    );
    for (i, panel) in panels.iter().enumerate() {
        let x = PANEL_WIDTH * i as f64 + LEFT;
        _ = write!(svg, r##"<g transform="translate({x} {TOP})">{}</g>"##, panel.draw());
    }
    svg + "</svg>\n"
}

impl Panel {
    fn draw(&self) -> String {
        let x = LogAxis::around(self.points.iter().map(|point| point.size), PLOT[0]);
        let values = self.points.iter().flat_map(|point| [point.ms, point.mb]);
        let y = LogAxis::around(values, PLOT[1]);
        let [width, height] = PLOT;
        let mut svg = format!(
            concat!(
                r##"<text y="-16" font-weight="bold">{}</text>"##,
                r##"<rect width="{}" height="{}" fill="none" stroke="#888"/>"##,
                r##"<text x="{}" y="{}" text-anchor="middle">{}</text>"##
            ),
            self.title,
            width,
            height,
            0.5 * width,
            height + 34.0,
            self.x_label
        );
        for power in x.powers() {
            let at = x.place(10_f64.powi(power));
            _ = write!(svg, r##"<path d="M{at} 0V{height}" stroke="#ddd"/>"##);
            _ = write!(
                svg,
                r##"<text x="{at}" y="{}" text-anchor="middle">{}</text>"##,
                height + 16.0,
                label(power)
            );
        }
        for power in y.powers() {
            let at = height - y.place(10_f64.powi(power));
            _ = write!(svg, r##"<path d="M0 {at}H{width}" stroke="#ddd"/>"##);
            _ = write!(svg, r##"<text x="-6" y="{}" text-anchor="end">{}</text>"##, at + 4.0, label(power));
        }
        let ms: fn(&Measurement) -> f64 = |point| point.ms;
        for (i, (unit, color, dash, value)) in
            [("ms", "#0060a0", "", ms), ("MB", "#b04000", "5 3", |point| point.mb)].into_iter().enumerate()
        {
            let place = |point: &Measurement| {
                format!("{:.1},{:.1}", x.place(point.size), height - y.place(value(point)))
            };
            let places: Vec<String> = self.points.iter().map(place).collect();
            // Curves rise to the right, which leaves the upper left corner for their names.
            let name_y = 18.0 + 16.0 * i as f64;
            _ = write!(
                svg,
                concat!(
                    r##"<g fill="none" stroke="{1}" stroke-width="2" stroke-dasharray="{2}"><polyline points="{0}"/>"##,
                    r##"<path d="M8 {4}h24"/></g><text x="38" y="{3}">{5}, power {6:.2}</text>"##
                ),
                places.join(" "),
                color,
                dash,
                name_y,
                name_y - 4.0,
                unit,
                exponent(&self.points, value)
            );
        }
        svg
    }
}

/// A logarithmic axis over whole powers of ten.
struct LogAxis {
    low: i32,
    high: i32,
    length: f64,
}

impl LogAxis {
    fn around(values: impl Iterator<Item = f64>, length: f64) -> Self {
        let (low, high) = values.fold((f64::INFINITY, 0.0_f64), |(low, high), v| (low.min(v), high.max(v)));
        let (low, high) = (low.log10().floor() as i32, high.log10().ceil() as i32);
        Self { low, high: high.max(low + 1), length }
    }

    fn powers(&self) -> impl Iterator<Item = i32> + use<> {
        self.low..=self.high
    }

    fn place(&self, value: f64) -> f64 {
        (value.log10() - self.low as f64) / (self.high - self.low) as f64 * self.length
    }
}

fn label(power: i32) -> String {
    match power {
        0..=3 => format!("{}", 10_i32.pow(power as u32)),
        _ => format!("10<tspan dy=\"-4\" font-size=\"8\">{power}</tspan>"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(power: f64) -> Vec<Measurement> {
        (0..6)
            .map(|i| 10_f64.powf(0.5 * i as f64))
            .map(|size| Measurement { size, ms: 3.0 * size.powf(power), mb: 7.0 })
            .collect()
    }

    #[test]
    fn the_exponent_is_that_of_the_power_law() {
        assert!((exponent(&points(1.5), |point| point.ms) - 1.5).abs() < 1e-12);
        assert!(exponent(&points(1.5), |point| point.mb).abs() < 1e-12);
    }

    #[test]
    fn a_drawing_names_what_it_shows() {
        let panel =
            Panel { title: "decision".to_owned(), x_label: "candidates".to_owned(), points: points(2.0) };
        let svg = draw(&[panel]);
        for part in ["<svg", "decision", "candidates", "ms, power 2.00", "MB, power 0.00", "</svg>"] {
            assert!(svg.contains(part), "{part} in {svg}");
        }
    }
}
