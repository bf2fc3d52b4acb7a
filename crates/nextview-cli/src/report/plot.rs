//! Curves over the number of views, or over a share, as an SVG drawing. Curves differ in dash and marker as well as in colour, which the style
//! sheet gives their classes.

use super::text::{escape, percent};

const LEFT: f64 = 52.0;
const TOP: f64 = 12.0;
/// Room below the plot for the numbers and the name of the axis.
const FOOT: f64 = 44.0;

/// Smallest vertical distance between two labels.
const LABEL_STEP: f64 = 17.0;

/// Curves in one pair of axes. All values are shares.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Plot {
    pub x_axis: Axis,
    /// What the curves show, for the axis.
    pub y_label: String,
    /// Lowest and highest value on the axis; tens of percent.
    pub y_range: [f64; 2],
    /// Width of the plot and of the room for labels right of it, height of the plot.
    pub size: [f64; 3],
    /// The first is drawn last, so that it lies on top.
    pub curves: Vec<Curve>,
}

/// What the values stand over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Axis {
    /// Numbers of views, from 1.
    Views,
    /// Whole percent of what has this name, 0 to 100.
    Percent(&'static str),
}

/// One curve.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Curve {
    /// CSS class.
    pub class: String,
    /// Its name, also right of its end; an empty one is not shown.
    pub label: String,
    pub marker: Marker,
    /// Place on the axis and value.
    pub points: Vec<(usize, f64)>,
    /// Place on the axis, lower and upper value of the area around the curve; may be empty.
    pub band: Vec<(usize, f64, f64)>,
}

/// The shape at the points of a curve. The style sheet decides whether it is filled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Marker {
    None,
    Circle,
    Square,
    Triangle,
    Diamond,
    TriangleDown,
    Cross,
}

impl Plot {
    /// The drawing.
    pub fn draw(&self) -> String {
        let [plot, room, height] = self.size;
        let mut svg = format!(
            r#"<svg class="chart" viewBox="0 0 {} {}" role="img" aria-label="{}">"#,
            LEFT + plot + room,
            TOP + height + FOOT,
            escape(&self.description())
        );
        svg += &self.axes();
        self.curves.iter().rev().for_each(|curve| svg += &self.band(curve));
        self.curves.iter().rev().for_each(|curve| svg += &self.curve(curve));
        svg += &self.labels();
        svg + "</svg>"
    }

    fn description(&self) -> String {
        let part = |c: &Curve| {
            let (x, value) = c.points.last().filter(|_| !c.label.is_empty())?;
            let place = match self.x_axis {
                Axis::Views => format!("after {x} views"),
                Axis::Percent(name) => format!("at {x} % {name}"),
            };
            Some(format!("{} reaches {} {place}", c.label, percent(*value)))
        };
        let parts: Vec<String> = self.curves.iter().filter_map(part).collect();
        let over = match self.x_axis {
            Axis::Views => "the number of views",
            Axis::Percent(name) => name,
        };
        match parts.as_slice() {
            [] => format!("{} over {over}", self.y_label),
            _ => format!("{} over {over}: {}.", self.y_label, parts.join("; ")),
        }
    }

    /// Where the horizontal axis begins and ends.
    fn x_range(&self) -> [usize; 2] {
        let last = || self.curves.iter().flat_map(|c| &c.points).map(|p| p.0).max();
        match self.x_axis {
            Axis::Views => [1, last().unwrap_or(1).max(2)],
            Axis::Percent(_) => [0, 100],
        }
    }

    fn right(&self) -> f64 {
        LEFT + self.size[0]
    }

    fn bottom(&self) -> f64 {
        TOP + self.size[2]
    }

    fn x(&self, place: usize) -> f64 {
        let [low, high] = self.x_range();
        LEFT + 8.0 + (self.size[0] - 16.0) * (place - low) as f64 / (high - low) as f64
    }

    fn y(&self, value: f64) -> f64 {
        let [low, high] = self.y_range;
        self.bottom() - self.size[2] * ((value - low) / (high - low)).clamp(0.0, 1.0)
    }

    fn axes(&self) -> String {
        let (right, bottom) = (self.right(), self.bottom());
        let [low, high] = self.y_range.map(|share| (100.0 * share).round() as usize);
        let mut svg = String::new();
        let step = if high - low > 50 { 20 } else { 10 };
        for tick in (low..=high).filter(|tick| tick % step == 0) {
            let y = self.y(tick as f64 / 100.0);
            svg += &format!(r#"<path class="grid" d="M{LEFT} {y:.1}H{right}"/>"#);
            svg += &format!(r#"<text class="end" x="{}" y="{:.1}">{tick}</text>"#, LEFT - 7.0, y + 4.5);
        }
        let (ticks, name) = match self.x_axis {
            Axis::Views => (view_ticks(self.x_range()[1]), "views".to_owned()),
            Axis::Percent(name) => ((0..=100).step_by(20).collect(), format!("{name}, %")),
        };
        for tick in ticks {
            let x = self.x(tick);
            svg += &format!(r#"<path class="axis" d="M{x:.1} {bottom}v4"/>"#);
            svg += &format!(r#"<text class="middle" x="{x:.1}" y="{}">{tick}</text>"#, bottom + 19.0);
        }
        let (middle_x, middle_y) = ((LEFT + right) / 2.0, (TOP + bottom) / 2.0);
        svg += &format!(r#"<path class="axis" d="M{LEFT} {TOP}V{bottom}H{right}"/>"#);
        svg +=
            &format!(r#"<text class="middle" x="{middle_x}" y="{}">{}</text>"#, bottom + 38.0, escape(&name));
        svg + &format!(
            r#"<text class="middle" transform="translate(14 {middle_y}) rotate(-90)">{}, %</text>"#,
            escape(&self.y_label)
        )
    }

    fn curve(&self, curve: &Curve) -> String {
        let at = |&(x, value): &(usize, f64)| (self.x(x), self.y(value));
        let line = polyline(curve.points.iter().map(at));
        let mut svg = format!(r#"<g class="{}"><path class="line" d="{line}"/>"#, curve.class);
        // More than about thirty markers would run into each other; the last point always has one.
        let marked = curve.points.iter().rev().step_by(curve.points.len().div_ceil(30).max(1));
        for point in marked.filter(|_| curve.marker != Marker::None) {
            let (x, y) = at(point);
            let value = percent(point.1);
            let place = match self.x_axis {
                Axis::Views => format!("view {}", point.0),
                Axis::Percent(_) => format!("{} %", point.0),
            };
            svg += &format!("<g><title>{}, {place}: {value}</title>", escape(&curve.label));
            svg += &format!("{}</g>", curve.marker.draw(x, y));
        }
        svg + "</g>"
    }

    fn band(&self, curve: &Curve) -> String {
        if curve.band.is_empty() {
            return String::new();
        }
        let high = curve.band.iter().map(|&(x, _, high)| (self.x(x), self.y(high)));
        let low = curve.band.iter().rev().map(|&(x, low, _)| (self.x(x), self.y(low)));
        format!(r#"<g class="{}"><path class="band" d="{}Z"/></g>"#, curve.class, polyline(high.chain(low)))
    }

    /// The name and last value of each curve, right of the plot, pushed apart where they would overlap.
    fn labels(&self) -> String {
        let named = self.curves.iter().filter(|curve| !curve.label.is_empty());
        let mut ends: Vec<(&Curve, usize, f64)> =
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
                r#"<text class="label {}" x="{}" y="{:.1}">{} {:.1}</text>"#,
                curve.class,
                right + 6.0,
                y + 4.5,
                escape(&curve.label),
                100.0 * value
            );
        }
        svg
    }
}

impl Marker {
    /// The shape around a point.
    pub fn draw(self, x: f64, y: f64) -> String {
        let path = |d: &str, x: f64, y: f64| format!(r#"<path class="mark" d="M{x:.1} {y:.1}{d}"/>"#);
        match self {
            Self::None => String::new(),
            Self::Circle => format!(r#"<circle class="mark" cx="{x:.1}" cy="{y:.1}" r="3.6"/>"#),
            Self::Square => path("h6v6h-6z", x - 3.0, y - 3.0),
            Self::Triangle => path("l3.8 6.6h-7.6z", x, y - 4.4),
            Self::TriangleDown => path("l3.8 -6.6h-7.6z", x, y + 4.4),
            Self::Diamond => path("l4.4 4.4l-4.4 4.4l-4.4 -4.4z", x, y - 4.4),
            Self::Cross => path("l6.4 6.4m0 -6.4l-6.4 6.4", x - 3.2, y - 3.2),
        }
    }
}

/// An item of a legend: a piece of a curve of this class, with a band or else a line and its marker.
pub(crate) fn legend_item(class: &str, marker: Option<Marker>, text: &str) -> String {
    let drawing = match marker {
        Some(marker) => format!(r#"<path class="line" d="M1 6H37"/>{}"#, marker.draw(19.0, 6.0)),
        None => r#"<path class="band" d="M1 1H37V11H1Z"/>"#.to_owned(),
    };
    format!(
        r#"<li><svg class="chart key" viewBox="0 0 38 12" aria-hidden="true"><g class="{class}">{drawing}</g></svg>{}</li>"#,
        escape(text)
    )
}

/// View 1 and round numbers, at most about ten.
pub(crate) fn view_ticks(n_views: usize) -> Vec<usize> {
    let round = (0..).flat_map(|e| [1, 2, 5].map(|m| m * 10_usize.pow(e)));
    let step = round.into_iter().find(|step| n_views / step <= 10).unwrap_or(1);
    let rest = (1..=n_views / step).map(|i| i * step).filter(|&view| view > 1);
    std::iter::once(1).chain(rest).collect()
}

fn polyline(points: impl Iterator<Item = (f64, f64)>) -> String {
    let corner =
        |(i, (x, y)): (usize, (f64, f64))| format!("{}{x:.1} {y:.1}", if i == 0 { "M" } else { "L" });
    points.enumerate().map(corner).collect()
}

/// Moves sorted heights apart to [`LABEL_STEP`], above the bottom.
fn spread(heights: &mut [f64], bottom: f64) {
    for i in 1..heights.len() {
        heights[i] = heights[i].max(heights[i - 1] + LABEL_STEP);
    }
    let mut limit = bottom;
    for height in heights.iter_mut().rev() {
        *height = height.min(limit);
        limit = *height - LABEL_STEP;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_few_and_round() {
        assert_eq!(view_ticks(4), [1, 2, 3, 4]);
        assert_eq!(view_ticks(12), [1, 2, 4, 6, 8, 10, 12]);
        assert_eq!(view_ticks(100), [1, 10, 20, 30, 40, 50, 60, 70, 80, 90, 100]);
    }

    #[test]
    fn labels_keep_their_distance_and_stay_inside() {
        let bottom = 306.0;
        for mut heights in [vec![20.0, 21.0, 22.0], vec![TOP, 100.0, 101.0], vec![bottom; 3]] {
            spread(&mut heights, bottom);
            assert!(heights.windows(2).all(|w| w[1] - w[0] >= LABEL_STEP - 1e-9), "{heights:?}");
            assert!(heights.iter().all(|h| (TOP..=bottom).contains(h)), "{heights:?}");
        }
    }
}
