//! The node's subscriptions and publications over DDS.

mod connector;
mod inputs;
mod outputs;
mod services;

pub use connector::{Connector, join};
pub use inputs::{Inputs, Message};
pub use outputs::{OutgoingMessage, Outputs};
pub use services::{Service, Services};
