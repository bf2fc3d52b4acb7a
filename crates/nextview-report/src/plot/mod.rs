//! Curves over the number of views, or over a share, as an SVG drawing.
//!
//! Curves differ in dash and marker as well as in colour; the style sheet sets them by class.

mod draw;
mod labels;
mod layout;
mod marker;
mod ticks;

pub(crate) use layout::{HorizontalAxis, Plot, PlotCurve};
pub(crate) use marker::{CurveMarker, legend_item};
pub(crate) use ticks::view_ticks;
