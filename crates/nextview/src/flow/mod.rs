//! Assignment of items to channels and sets.
