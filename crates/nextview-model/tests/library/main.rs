//! The model from outside. One program, so that it is linked once.

mod nonsense;
mod surface_model;
