//! How an object lies: its rest poses, the one that exposes most of the unseen surface, and how it was
//! turned.
//!
//! A placement is the time during which the object lies still. [`ShownObject`] holds what the frames of one
//! placement have shown. [`find_turn`] finds how the object was turned before the next one;
//! [`next_placement`] plans that turn. The formulas are in `docs/methods/placement.md`.

mod farthest;
mod rest;
mod shown_object;
mod turn;
mod unseen;

pub use rest::{Rest, rests};
pub use shown_object::ShownObject;
pub use turn::{Turn, TurnRefusal, find_turn};
pub use unseen::{NextPlacement, next_placement};
