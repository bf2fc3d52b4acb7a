//! Which clients may send requests, and for which host.

mod host;
mod token;

pub(crate) use host::Hosts;
pub(crate) use token::{Token, random_hex};

/// Which clients may send requests.
pub(crate) struct Access {
    /// The names that the server goes by.
    pub hosts: Hosts,
    /// The token of the page.
    pub page: Token,
    /// The token of all other clients; none where they need none.
    pub clients: Option<Token>,
}
