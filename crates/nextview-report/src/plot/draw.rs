//! The drawing as SVG.

use super::layout::{HorizontalAxis, LEFT, Plot, PlotCurve, TOP};
use super::marker::CurveMarker;
use super::ticks::view_ticks;
use crate::text::{escape, percent};

/// Room below the plot for the numbers and the name of the axis.
const FOOT: f64 = 44.0;

impl Plot {
    /// Draws the plot.
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
        let part = |c: &PlotCurve| {
            let (x, value) = c.points.last().filter(|_| !c.label.is_empty())?;
            let place = match self.x_axis {
                HorizontalAxis::Views => format!("after {x} views"),
                HorizontalAxis::Percent(name) => format!("at {x} % {name}"),
            };
            Some(format!("{} reaches {} {place}", c.label, percent(*value)))
        };
        let parts: Vec<String> = self.curves.iter().filter_map(part).collect();
        let over = match self.x_axis {
            HorizontalAxis::Views => "the number of views",
            HorizontalAxis::Percent(name) => name,
        };
        match parts.as_slice() {
            [] => format!("{} over {over}", self.y_label),
            _ => format!("{} over {over}: {}.", self.y_label, parts.join("; ")),
        }
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
            HorizontalAxis::Views => (view_ticks(self.x_range()[1]), "views".to_owned()),
            HorizontalAxis::Percent(name) => ((0..=100).step_by(20).collect(), format!("{name}, %")),
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

    fn curve(&self, curve: &PlotCurve) -> String {
        let at = |&(x, value): &(usize, f64)| (self.x(x), self.y(value));
        let line = polyline(curve.points.iter().map(at));
        let mut svg = format!(r#"<g class="{}"><path class="line" d="{line}"/>"#, curve.class);
        // More than about thirty markers would overlap; the last point always has one.
        let marked = curve.points.iter().rev().step_by(curve.points.len().div_ceil(30).max(1));
        for point in marked.filter(|_| curve.marker != CurveMarker::None) {
            let (x, y) = at(point);
            let value = percent(point.1);
            let place = match self.x_axis {
                HorizontalAxis::Views => format!("view {}", point.0),
                HorizontalAxis::Percent(_) => format!("{} %", point.0),
            };
            svg += &format!("<g><title>{}, {place}: {value}</title>", escape(&curve.label));
            svg += &format!("{}</g>", curve.marker.draw(x, y));
        }
        svg + "</g>"
    }

    fn band(&self, curve: &PlotCurve) -> String {
        if curve.band.is_empty() {
            return String::new();
        }
        let high = curve.band.iter().map(|&(x, _, high)| (self.x(x), self.y(high)));
        let low = curve.band.iter().rev().map(|&(x, low, _)| (self.x(x), self.y(low)));
        format!(r#"<g class="{}"><path class="band" d="{}Z"/></g>"#, curve.class, polyline(high.chain(low)))
    }
}

fn polyline(points: impl Iterator<Item = (f64, f64)>) -> String {
    let corner =
        |(i, (x, y)): (usize, (f64, f64))| format!("{}{x:.1} {y:.1}", if i == 0 { "M" } else { "L" });
    points.enumerate().map(corner).collect()
}
