//! The server, driven as by clients: in a separate process, over HTTP.

// `cfg(test)` lets Clippy know that the `unwrap`s of helpers, too, are those of a test.
#[cfg(test)]
mod access;
#[cfg(test)]
mod client;
#[cfg(test)]
mod contention;
#[cfg(test)]
mod hostile;
#[cfg(test)]
mod in_a_hand;
#[cfg(test)]
mod kills;
#[cfg(test)]
mod process;
#[cfg(test)]
mod robot;
#[cfg(test)]
mod same_scan;
#[cfg(test)]
mod session;
#[cfg(test)]
mod watcher;
