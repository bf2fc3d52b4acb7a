//! What the node is told when it starts: arguments, files of parameters, and what they mean.

mod arguments;
mod file;
mod parameter_set;
mod value;

pub use arguments::RosArguments;
pub use parameter_set::Parameters;
