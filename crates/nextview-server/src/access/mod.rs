//! Access control: the clients that may send requests, and the hosts they may name.

mod host;
mod token;

pub(crate) use host::Hosts;
pub(crate) use token::{Token, random_hex};

/// The clients that may send requests.
pub(crate) struct Access {
    /// The names of the server.
    pub hosts: Hosts,
    /// The token of the page.
    pub page: Token,
    /// The token of all other clients; `None` if they need none.
    pub clients: Option<Token>,
}
