//! The layers of the networks.
//!
//! All are plain loops that are fast with the CPU's instructions: call them from within
//! [`WithSimd::with_simd`](pulp::WithSimd). Every number is computed in the same order of operations on every
//! CPU, by one thread, so the results have the same bits.

mod convolution;
mod dense;

pub(crate) use convolution::convolve;
pub(crate) use dense::Dense;

/// Sets negative values to 0.
#[inline(always)]
pub(crate) fn rectify(values: &mut [f32]) {
    values.iter_mut().for_each(|value| *value = if *value > 0.0 { *value } else { 0.0 });
}

#[cfg(test)]
pub(crate) use convolution::tests::{slow_convolution, slow_pool};
#[cfg(test)]
pub(crate) use dense::tests::slow_dense;
