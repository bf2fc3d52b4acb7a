//! Shapes at the points of curves, and the legend that explains them.

use crate::text::escape;

/// The shape at the points of a curve. The style sheet decides whether it is filled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CurveMarker {
    None,
    Circle,
    Square,
    Triangle,
    Diamond,
    TriangleDown,
    Cross,
}

impl CurveMarker {
    /// Draws the shape around a point.
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

/// A legend item: a piece of a curve of this class, with a band or with a line and its marker.
pub(crate) fn legend_item(class: &str, marker: Option<CurveMarker>, text: &str) -> String {
    let drawing = match marker {
        Some(marker) => format!(r#"<path class="line" d="M1 6H37"/>{}"#, marker.draw(19.0, 6.0)),
        None => r#"<path class="band" d="M1 1H37V11H1Z"/>"#.to_owned(),
    };
    format!(
        r#"<li><svg class="chart key" viewBox="0 0 38 12" aria-hidden="true"><g class="{class}">{drawing}</g></svg>{}</li>"#,
        escape(text)
    )
}
