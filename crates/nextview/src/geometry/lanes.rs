//! Vector lanes of voxel traversal: a number per segment or ray, and indices of cells in floating-point
//! registers.
//!
//! Everything here must be inlined: other functions are compiled without vector instructions.

use pulp::Simd;

/// Number of lanes in the widest instructions.
pub(crate) const LANES: usize = 8;

/// A number per lane.
pub(crate) type Lanes = [f64; LANES];

/// The index of cell 0. An index is the number of a cell plus 2^52: the number is then in the low bits, and
/// steps can be added in floating-point registers.
pub(crate) const FIRST_INDEX: f64 = (1_u64 << 52) as f64;

/// Returns the cell of an index.
#[inline(always)]
pub(crate) fn cell(index: f64) -> usize {
    index.to_bits() as u32 as usize
}

/// Loads register number `part`, from 0, of all lanes.
#[inline(always)]
pub(crate) fn load<S: Simd>(lanes: &Lanes, part: usize) -> S::f64s {
    S::as_simd_f64s(lanes).0[part]
}

/// The reverse of [`load`].
#[inline(always)]
pub(crate) fn store<S: Simd>(lanes: &mut Lanes, part: usize, value: S::f64s) {
    S::as_mut_simd_f64s(lanes).0[part] = value;
}

/// Whether any lane of a mask is set.
#[inline(always)]
pub(crate) fn any<S: Simd>(simd: S, mask: S::m64s) -> bool {
    simd.reduce_max_f64s(simd.select_f64s(mask, simd.splat_f64s(1.0), simd.splat_f64s(0.0))) > 0.0
}

/// Rounds numbers from 0 to 2^51 to the nearest integer, ties to even.
#[inline(always)]
pub(crate) fn round<S: Simd>(simd: S, x: S::f64s) -> S::f64s {
    let base = simd.splat_f64s(FIRST_INDEX);
    simd.sub_f64s(simd.add_f64s(x, base), base)
}

/// Returns the floor of numbers from 0 to 2^51.
#[inline(always)]
pub(crate) fn floor<S: Simd>(simd: S, x: S::f64s) -> S::f64s {
    let nearest = round(simd, x);
    let above = simd.greater_than_f64s(nearest, x);
    simd.select_f64s(above, simd.sub_f64s(nearest, simd.splat_f64s(1.0)), nearest)
}

/// Returns the absolute value; the vector library's own function is not always inlined.
#[inline(always)]
pub(crate) fn abs<S: Simd>(simd: S, x: S::f64s) -> S::f64s {
    simd.max_f64s(x, simd.sub_f64s(simd.splat_f64s(0.0), x))
}
