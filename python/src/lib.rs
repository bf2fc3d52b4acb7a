//! The compiled part of the Python package `nextview`: converts arrays and values, and decides nothing.
//!
//! User documentation is in the Python sources next to this crate; they check nothing either.

mod arrays;
mod bench;
mod camera;
mod campaign;
mod errors;
mod export;
mod live_scan;
mod map_file;
mod model;
mod offline_scan;
mod pictures;
mod plan_input;
mod planner;
mod planner_class;
mod pose;
mod records;
mod results;
mod scene;
mod shown;
mod values;
mod view;
mod watch;

use pyo3::prelude::*;

/// The module `nextview._native`.
#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    planner::provide();
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<camera::Camera>()?;
    module.add_class::<view::View>()?;
    module.add_class::<live_scan::LiveScan>()?;
    module.add_class::<pictures::Finished>()?;
    module.add_class::<scene::Scene>()?;
    module.add_class::<campaign::Campaign>()?;
    module.add_class::<campaign::BatchRuns>()?;
    module.add_function(wrap_pyfunction!(offline_scan::scan, module)?)?;
    module.add_function(wrap_pyfunction!(bench::bench, module)?)?;
    module.add_function(wrap_pyfunction!(export::export, module)?)?;
    module.add_function(wrap_pyfunction!(map_file::read_map, module)?)?;
    module.add_function(wrap_pyfunction!(map_file::write_map, module)?)?;
    module.add_function(wrap_pyfunction!(view::view_of_text, module)?)?;
    module.add_function(wrap_pyfunction!(values::read_config, module)?)?;
    module.add_function(wrap_pyfunction!(values::planners, module)?)?;
    module.add_function(wrap_pyfunction!(values::sensors, module)?)?;
    module.add_function(wrap_pyfunction!(values::builtin_objects, module)?)
}
