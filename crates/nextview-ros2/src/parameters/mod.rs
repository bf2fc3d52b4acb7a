//! The input of the node at startup: arguments, parameter files, and their meaning.

mod arguments;
mod file;
mod parameter_set;
mod value;

pub use arguments::RosArguments;
pub use parameter_set::Parameters;
