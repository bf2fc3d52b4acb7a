//! Curves in one pair of axes, and where they lie in the drawing.

use super::marker::Marker;

/// Where the plot begins at the left.
pub(super) const LEFT: f64 = 52.0;

/// Where it begins at the top.
pub(super) const TOP: f64 = 12.0;

/// Curves in one pair of axes. All values are shares.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Plot {
    pub x_axis: Axis,
    /// Name of the vertical axis.
    pub y_label: String,
    /// Lowest and highest value on the axis; tens of percent.
    pub y_range: [f64; 2],
    /// Width of the plot and of the room for labels right of it, height of the plot.
    pub size: [f64; 3],
    /// The first is drawn last, so that it lies on top.
    pub curves: Vec<Curve>,
}

/// The horizontal axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Axis {
    /// Numbers of views, from 1.
    Views,
    /// Whole percent, 0 to 100, of the quantity with this name.
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

impl Plot {
    /// Where the horizontal axis begins and ends.
    pub fn x_range(&self) -> [usize; 2] {
        let last = || self.curves.iter().flat_map(|c| &c.points).map(|p| p.0).max();
        match self.x_axis {
            Axis::Views => [1, last().unwrap_or(1).max(2)],
            Axis::Percent(_) => [0, 100],
        }
    }

    /// Where the plot ends at the right.
    pub fn right(&self) -> f64 {
        LEFT + self.size[0]
    }

    /// Where the plot ends at the bottom.
    pub fn bottom(&self) -> f64 {
        TOP + self.size[2]
    }

    /// The horizontal position of a place on the axis.
    pub fn x(&self, place: usize) -> f64 {
        let [low, high] = self.x_range();
        LEFT + 8.0 + (self.size[0] - 16.0) * (place - low) as f64 / (high - low) as f64
    }

    /// The vertical position of a value; values outside the axis lie on its end, and those that are no number
    /// at the bottom.
    pub fn y(&self, value: f64) -> f64 {
        let [low, high] = self.y_range;
        let share = Some((value - low) / (high - low)).filter(|share| !share.is_nan());
        self.bottom() - self.size[2] * share.unwrap_or(0.0).clamp(0.0, 1.0)
    }
}
