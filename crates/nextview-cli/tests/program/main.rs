//! The program, driven as by a user.

// `cfg(test)` lets Clippy know that the `unwrap`s of helpers, too, are those of a test.
#[cfg(test)]
mod bad_input;
#[cfg(test)]
mod bench;
#[cfg(test)]
#[cfg(target_os = "linux")]
mod bombs;
#[cfg(test)]
mod campaigns;
#[cfg(test)]
mod commands;
#[cfg(test)]
mod common;
#[cfg(test)]
mod dataset;
#[cfg(test)]
mod determinism;
#[cfg(test)]
mod export;
#[cfg(test)]
mod first_scan;
#[cfg(test)]
mod help;
#[cfg(test)]
mod inspect;
#[cfg(test)]
#[cfg(unix)]
mod interrupt;
#[cfg(test)]
#[cfg(unix)]
mod irregular;
mod kept;
#[cfg(test)]
mod map_and_views;
#[cfg(test)]
mod methods;
#[cfg(test)]
mod motion;
#[cfg(test)]
mod overwriting;
#[cfg(test)]
mod ply;
#[cfg(test)]
mod recorded;
#[cfg(test)]
mod recording;
#[cfg(test)]
#[cfg(unix)]
mod resume;
#[cfg(test)]
mod scan;
#[cfg(test)]
mod shards;
#[cfg(test)]
mod shell;
#[cfg(test)]
mod text_files;
#[cfg(test)]
mod turned;
