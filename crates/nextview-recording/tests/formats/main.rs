//! Recordings of a simulated camera, written in every form and read back.

// `cfg(test)` lets Clippy know that the `unwrap`s of helpers, too, are those of a test.
#[cfg(test)]
mod color;
#[cfg(test)]
mod data;
#[cfg(test)]
mod faults;
#[cfg(test)]
mod jpeg;
#[cfg(test)]
mod maps;
#[cfg(test)]
mod mcap;
#[cfg(test)]
mod rosbags;
#[cfg(test)]
mod synthetic;
#[cfg(test)]
mod transforms;
