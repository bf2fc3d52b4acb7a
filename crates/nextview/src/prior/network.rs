use super::VoxelFeatures;
use crate::instructions::instructions;
use crate::{Cancel, Cancelled};
use pulp::{Simd, WithSimd};
use rayon::prelude::*;

/// A small network from the features of a voxel to logits: two hidden layers of rectified linear units.
///
/// Every voxel is computed in the same order of operations on every CPU, so results are equal to the last
/// bit.
#[derive(Clone, Debug, PartialEq)]
pub struct Network {
    n_outputs: usize,
    /// The mean subtracted from each feature, and the factor it is then multiplied by.
    mean: [f32; VoxelFeatures::N],
    scale: [f32; VoxelFeatures::N],
    /// The three layers in sequence: for each input the weights to all outputs, then the biases.
    weights: Vec<f32>,
}

/// The units of the hidden layers.
const HIDDEN: [usize; 2] = [32, 16];

/// Number of weights of the layers before the last.
const FIRST: usize = (VoxelFeatures::N + 1) * HIDDEN[0];
const SECOND: usize = (HIDDEN[0] + 1) * HIDDEN[1];

/// Number of voxels that a thread computes at a time.
const CHUNK: usize = 512;

impl Network {
    /// The units of the hidden layers.
    pub const HIDDEN: [usize; 2] = HIDDEN;

    /// Number of values that describe a network with this number of outputs.
    pub const fn n_numbers(n_outputs: usize) -> usize {
        2 * VoxelFeatures::N + FIRST + SECOND + (HIDDEN[1] + 1) * n_outputs
    }

    /// Creates the network from these numbers: mean and scale of the features, then for each layer the
    /// weights of each input to all outputs, and the biases.
    ///
    /// `None` unless there are [`n_numbers`](Self::n_numbers), all finite, and at least one output.
    pub fn from_numbers(numbers: &[f32], n_outputs: usize) -> Option<Self> {
        let is_whole = n_outputs > 0 && numbers.len() == Self::n_numbers(n_outputs);
        if !is_whole || numbers.iter().any(|number| !number.is_finite()) {
            return None;
        }
        let (mean, rest) = numbers.split_first_chunk()?;
        let (scale, weights) = rest.split_first_chunk()?;
        Some(Self { n_outputs, mean: *mean, scale: *scale, weights: weights.to_vec() })
    }

    /// Number of probabilities for each row.
    pub fn n_outputs(&self) -> usize {
        self.n_outputs
    }

    /// Returns the numbers that describe the network.
    pub fn numbers(&self) -> Vec<f32> {
        self.mean.iter().chain(&self.scale).chain(&self.weights).copied().collect()
    }

    /// Returns the probabilities of each row, row by row.
    ///
    /// Fails if `cancel` is set.
    pub fn probabilities(
        &self,
        rows: &[[f32; VoxelFeatures::N]],
        cancel: &Cancel,
    ) -> Result<Vec<f32>, Cancelled> {
        let mut out = vec![0.0; rows.len() * self.n_outputs];
        let parts = out.par_chunks_mut(CHUNK * self.n_outputs).zip(rows.par_chunks(CHUNK));
        parts.try_for_each(|(out, rows)| {
            cancel.check()?;
            instructions().dispatch(Forward { network: self, rows, out });
            Ok(())
        })?;
        Ok(out)
    }
}

/// Computes probabilities, with the instructions of the CPU.
struct Forward<'a> {
    network: &'a Network,
    rows: &'a [[f32; VoxelFeatures::N]],
    out: &'a mut [f32],
}

impl WithSimd for Forward<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { network, rows, out } = self;
        let n = network.n_outputs;
        for row in 0..rows.len() {
            network.forward(&rows[row], &mut out[row * n..(row + 1) * n]);
        }
    }
}

#[allow(clippy::needless_range_loop, reason = "iterators are not always inlined into vector instructions")]
impl Network {
    /// The probabilities of one row.
    #[inline(always)]
    fn forward(&self, row: &[f32; VoxelFeatures::N], out: &mut [f32]) {
        let (hidden, last) = (self.hidden(row), &self.weights[FIRST + SECOND..]);
        let n = self.n_outputs;
        out.copy_from_slice(&last[HIDDEN[1] * n..]);
        for input in 0..HIDDEN[1] {
            for output in 0..n {
                out[output] += hidden[input] * last[input * n + output];
            }
        }
        for output in 0..n {
            out[output] = 1.0 / (1.0 + (-out[output]).exp());
        }
    }

    /// The outputs of the second hidden layer.
    #[inline(always)]
    fn hidden(&self, row: &[f32; VoxelFeatures::N]) -> [f32; HIDDEN[1]] {
        let (first, second) = self.weights[..FIRST + SECOND].split_at(FIRST);
        let mut wide = [0.0; HIDDEN[0]];
        wide.copy_from_slice(&first[VoxelFeatures::N * HIDDEN[0]..]);
        for input in 0..VoxelFeatures::N {
            let value = (row[input] - self.mean[input]) * self.scale[input];
            let weights = &first[input * HIDDEN[0]..][..HIDDEN[0]];
            for unit in 0..HIDDEN[0] {
                wide[unit] += value * weights[unit];
            }
        }
        let mut narrow = [0.0; HIDDEN[1]];
        narrow.copy_from_slice(&second[HIDDEN[0] * HIDDEN[1]..]);
        for input in 0..HIDDEN[0] {
            let (value, weights) = (rectified(wide[input]), &second[input * HIDDEN[1]..][..HIDDEN[1]]);
            for unit in 0..HIDDEN[1] {
                narrow[unit] += value * weights[unit];
            }
        }
        for unit in 0..HIDDEN[1] {
            narrow[unit] = rectified(narrow[unit]);
        }
        narrow
    }
}

#[inline(always)]
fn rectified(value: f32) -> f32 {
    if value > 0.0 { value } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::random::Random;
    use crate::instructions::tests::archs;
    use proptest::prelude::*;

    const N: usize = VoxelFeatures::N;

    fn numbers(n_outputs: usize, seed: u64) -> Vec<f32> {
        let mut random = Random::new(seed, 0);
        (0..Network::n_numbers(n_outputs)).map(|_| random.range(-1.0, 1.0) as f32).collect()
    }

    fn rows(n: usize, seed: u64) -> Vec<[f32; N]> {
        let mut random = Random::new(seed, 1);
        (0..n).map(|_| std::array::from_fn(|_| random.range(-2.0, 4.0) as f32)).collect()
    }

    /// A layer of the slow twin; it takes its weights from the front of the numbers.
    fn layer(numbers: &mut impl Iterator<Item = f64>, inputs: &[f64], n_outputs: usize) -> Vec<f64> {
        let mut outputs = vec![0.0; n_outputs];
        for input in inputs.iter().chain([&1.0]) {
            outputs.iter_mut().for_each(|output| *output += input * numbers.next().unwrap());
        }
        outputs
    }

    fn slow_probabilities(numbers: &[f32], n_outputs: usize, row: &[f32; N]) -> Vec<f64> {
        let (mean, scale) = (&numbers[..N], &numbers[N..2 * N]);
        let mut weights = numbers[2 * N..].iter().map(|&number| number as f64);
        let mut values: Vec<f64> =
            (0..N).map(|i| (row[i] as f64 - mean[i] as f64) * scale[i] as f64).collect();
        for n_units in Network::HIDDEN {
            values = layer(&mut weights, &values, n_units);
            values.iter_mut().for_each(|value| *value = value.max(0.0));
        }
        let logits = layer(&mut weights, &values, n_outputs);
        assert_eq!(weights.next(), None, "all numbers are used");
        logits.into_iter().map(|logit| 1.0 / (1.0 + (-logit).exp())).collect()
    }

    fn bits(values: &[f32]) -> Vec<u32> {
        values.iter().map(|value| value.to_bits()).collect()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]

        #[test]
        fn computes_what_the_slow_twin_computes(seed: u64, n_outputs in prop::sample::select(vec![1, 3, 25]), n_rows in 0_usize..40) {
            let (numbers, rows) = (numbers(n_outputs, seed), rows(n_rows, seed));
            let found = Network::from_numbers(&numbers, n_outputs).unwrap().probabilities(&rows, &Cancel::default()).unwrap();
            let expected: Vec<f64> =
                rows.iter().flat_map(|row| slow_probabilities(&numbers, n_outputs, row)).collect();
            prop_assert_eq!(found.len(), expected.len());
            for (found, expected) in found.into_iter().zip(expected) {
                // Logits are sums of up to a few hundred, rounded to a few millionths.
                prop_assert!((0.0..=1.0).contains(&found) && (found as f64 - expected).abs() < 1e-4, "{found} {expected}");
            }
        }

        #[test]
        fn has_the_same_bits_with_all_instructions_and_threads(seed: u64, n_outputs in prop::sample::select(vec![1, 25])) {
            let network = Network::from_numbers(&numbers(n_outputs, seed), n_outputs).unwrap();
            let rows = rows(3 * CHUNK + 7, seed);
            let found = bits(&network.probabilities(&rows, &Cancel::default()).unwrap());
            for arch in archs() {
                let mut out = vec![0.0; rows.len() * n_outputs];
                arch.dispatch(Forward { network: &network, rows: &rows, out: &mut out });
                prop_assert_eq!(&bits(&out), &found, "{:?}", arch);
            }
            for n_threads in [1, 3] {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build().unwrap();
                prop_assert_eq!(&bits(&pool.install(|| network.probabilities(&rows, &Cancel::default()).unwrap())), &found);
            }
        }
    }

    #[test]
    fn is_made_from_as_many_finite_numbers_as_it_has() {
        for n_outputs in [1, 2, 25] {
            let numbers = numbers(n_outputs, 3);
            let network = Network::from_numbers(&numbers, n_outputs).unwrap();
            assert_eq!(network.numbers(), numbers);
            assert_eq!(network.probabilities(&rows(5, 0), &Cancel::default()).unwrap().len(), 5 * n_outputs);
            assert_eq!(Network::from_numbers(&numbers[1..], n_outputs), None);
            assert_eq!(Network::from_numbers(&[&numbers[..], &[0.0]].concat(), n_outputs), None);
            assert_eq!(Network::from_numbers(&numbers, n_outputs + 1), None);
            for place in [0, N, 2 * N, numbers.len() - 1] {
                for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
                    let mut numbers = numbers.clone();
                    numbers[place] = bad;
                    assert_eq!(Network::from_numbers(&numbers, n_outputs), None, "{bad} at {place}");
                }
            }
        }
        assert_eq!(Network::from_numbers(&[], 1), None);
        assert_eq!(Network::from_numbers(&vec![0.0; Network::n_numbers(0)], 0), None, "no output");
    }

    #[test]
    fn huge_weights_give_probabilities() {
        let huge: Vec<f32> = numbers(25, 9).into_iter().map(|number| number * 1e6).collect();
        let found = Network::from_numbers(&huge, 25)
            .unwrap()
            .probabilities(&rows(20, 9), &Cancel::default())
            .unwrap();
        assert!(found.iter().all(|p| (0.0..=1.0).contains(p)));
    }
}
