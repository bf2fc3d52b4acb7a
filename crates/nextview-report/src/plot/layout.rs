//! Curves in one pair of axes, and their layout in the drawing.

use super::marker::CurveMarker;

/// Left edge of the plot.
pub(super) const LEFT: f64 = 52.0;

/// Top edge of the plot.
pub(super) const TOP: f64 = 12.0;

/// Curves in one pair of axes. All values are shares.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Plot {
    pub x_axis: HorizontalAxis,
    /// Name of the vertical axis.
    pub y_label: String,
    /// Lowest and highest value on the axis; tens of percent.
    pub y_range: [f64; 2],
    /// Width of the plot and of the label area to its right, and height of the plot.
    pub size: [f64; 3],
    /// Curves, the first of which is drawn last, on top.
    pub curves: Vec<PlotCurve>,
}

/// The horizontal axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum HorizontalAxis {
    /// Numbers of views, from 1.
    Views,
    /// Whole percent, 0 to 100, of the quantity with this name.
    Percent(&'static str),
}

/// One curve.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PlotCurve {
    /// CSS class.
    pub class: String,
    /// Name, also shown to the right of the end; not shown if empty.
    pub label: String,
    pub marker: CurveMarker,
    /// Place on the axis and value.
    pub points: Vec<(usize, f64)>,
    /// Place on the axis, lower and upper value of the band around the curve; may be empty.
    pub band: Vec<(usize, f64, f64)>,
}

impl Plot {
    /// Returns the ends of the horizontal axis.
    pub fn x_range(&self) -> [usize; 2] {
        let last = || self.curves.iter().flat_map(|c| &c.points).map(|p| p.0).max();
        match self.x_axis {
            HorizontalAxis::Views => [1, last().unwrap_or(1).max(2)],
            HorizontalAxis::Percent(_) => [0, 100],
        }
    }

    /// Right edge of the plot.
    pub fn right(&self) -> f64 {
        LEFT + self.size[0]
    }

    /// Bottom edge of the plot.
    pub fn bottom(&self) -> f64 {
        TOP + self.size[2]
    }

    /// Returns the horizontal position of a place on the axis.
    pub fn x(&self, place: usize) -> f64 {
        let [low, high] = self.x_range();
        LEFT + 8.0 + (self.size[0] - 16.0) * (place - low) as f64 / (high - low) as f64
    }

    /// The vertical position of a value. Values outside the axis lie at its end, NaN at the bottom.
    pub fn y(&self, value: f64) -> f64 {
        let [low, high] = self.y_range;
        let share = Some((value - low) / (high - low)).filter(|share| !share.is_nan());
        self.bottom() - self.size[2] * share.unwrap_or(0.0).clamp(0.0, 1.0)
    }
}
