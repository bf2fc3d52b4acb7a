use std::ops::Range;

/// A rectangle of pixels.
///
/// Four numbers: first column, first row, and the negated column and row after the last. One vector minimum
/// joins two boxes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PixelBox([i32; 4]);

impl PixelBox {
    /// The empty box, neutral in `join`.
    pub const NOTHING: Self = Self([i32::MAX; 4]);

    /// A box from `first` to `end`, exclusive, column and row.
    #[inline(always)]
    pub fn new(first: [i32; 2], end: [i32; 2]) -> Self {
        Self([first[0], first[1], -end[0], -end[1]])
    }

    /// The smallest box that holds both.
    #[inline(always)]
    pub fn join(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i].min(other.0[i])))
    }

    /// Returns whether it holds no pixel.
    #[inline(always)]
    pub fn is_empty(self) -> bool {
        (self.0[0] >= -self.0[2]) | (self.0[1] >= -self.0[3])
    }

    #[inline(always)]
    pub fn columns(self) -> Range<usize> {
        self.0[0] as usize..-self.0[2] as usize
    }

    #[inline(always)]
    pub fn rows(self) -> Range<usize> {
        self.0[1] as usize..-self.0[3] as usize
    }
}
