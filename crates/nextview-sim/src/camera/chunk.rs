/// Number of values processed at once, by one vector instruction. The compiler may turn a loop over all of
/// them into vector instructions if each is computed without a branch.
pub(super) const LANES: usize = 8;

/// A number for each of [`LANES`] neighbours.
pub(super) type Chunk = [f64; LANES];

/// The larger number. Unlike `f64::max` it does not handle NaN, and so is one instruction.
#[inline(always)]
pub(super) fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// The smaller number.
#[inline(always)]
pub(super) fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}
