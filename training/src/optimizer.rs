use nextview::Cancel;
use nextview::geometry::random::Random;
use nextview::prior::{Network, VoxelFeatures};

/// A training sample: whether a statement holds for a voxel with these features.
#[derive(Clone, Copy, Debug)]
pub struct VoxelSample {
    /// The features of the voxel.
    pub row: [f32; N],
    /// The trained output of the network.
    pub output: u8,
    /// The target of this output.
    pub is_so: bool,
}

const N: usize = VoxelFeatures::N;
const WIDE: usize = Network::HIDDEN[0];
const NARROW: usize = Network::HIDDEN[1];

/// Number of samples between two steps.
const BATCH: usize = 256;

/// Length of the first steps; the last ones are a fiftieth of it.
const STEP: f32 = 2e-3;

/// Trains a network on randomly drawn samples, `n_epochs` times their number: Adam (Kingma & Ba 2015) on the
/// cross entropy, with linearly decreasing steps.
pub fn train(samples: &[VoxelSample], n_outputs: usize, n_epochs: usize, seed: u64) -> Network {
    let mut random = Random::new(seed, 5);
    let mut learner = Learner::new(samples, n_outputs, &mut random);
    let n_steps = n_epochs * samples.len() / BATCH;
    for step in 0..n_steps {
        for _ in 0..BATCH {
            learner.learn(&samples[random.index(samples.len())]);
        }
        let remaining = 1.0 - step as f32 / n_steps as f32;
        learner.step(step, STEP * remaining.max(0.02));
    }
    Network::from_numbers(&learner.numbers, n_outputs).expect("learning keeps weights finite")
}

/// Returns the mean cross entropy, nats per sample; lower is better.
pub fn loss(network: &Network, n_outputs: usize, samples: &[VoxelSample]) -> f64 {
    let rows: Vec<[f32; N]> = samples.iter().map(|sample| sample.row).collect();
    let probabilities = network.probabilities(&rows, &Cancel::default()).expect("nobody cancels");
    let losses = samples.iter().zip(probabilities.chunks_exact(n_outputs)).map(|(sample, outputs)| {
        let p = outputs[sample.output as usize] as f64;
        -(if sample.is_so { p } else { 1.0 - p }).max(1e-7).ln()
    });
    losses.sum::<f64>() / samples.len() as f64
}

/// A network with the state of the optimiser.
struct Learner {
    n_outputs: usize,
    /// Numbers in the order of [`Network::from_numbers`].
    numbers: Vec<f32>,
    gradient: Vec<f32>,
    mean: Vec<f32>,
    square: Vec<f32>,
}

/// Offset of the layers' weights among the numbers.
const FIRST: usize = 2 * N;
const SECOND: usize = FIRST + (N + 1) * WIDE;
const THIRD: usize = SECOND + (WIDE + 1) * NARROW;

impl Learner {
    fn new(samples: &[VoxelSample], n_outputs: usize, random: &mut Random) -> Self {
        let n = Network::n_numbers(n_outputs);
        let (mut means, mut scales) = ([0.0_f32; N], [0.0_f32; N]);
        for feature in 0..N {
            let values = || samples.iter().map(|sample| sample.row[feature] as f64);
            let mean = values().sum::<f64>() / samples.len() as f64;
            let variance = values().map(|value| (value - mean).powi(2)).sum::<f64>() / samples.len() as f64;
            means[feature] = mean as f32;
            scales[feature] = (1.0 / variance.max(1e-6).sqrt()) as f32;
        }
        let mut numbers = [means, scales].concat();
        for (n_in, n_out) in [(N, WIDE), (WIDE, NARROW), (NARROW, n_outputs)] {
            let bound = (6.0 / n_in as f64).sqrt(); // He et al. 2015
            numbers.extend((0..n_in * n_out).map(|_| random.range(-bound, bound) as f32));
            numbers.extend(vec![0.0; n_out]);
        }
        Self { n_outputs, numbers, gradient: vec![0.0; n], mean: vec![0.0; n], square: vec![0.0; n] }
    }

    /// Adds the gradient of the cross entropy of a sample.
    fn learn(&mut self, sample: &VoxelSample) {
        let mut inputs = [0.0; N];
        for (i, input) in inputs.iter_mut().enumerate() {
            *input = (sample.row[i] - self.numbers[i]) * self.numbers[N + i];
        }
        let wide: [f32; WIDE] = self.layer(FIRST, &inputs);
        let narrow: [f32; NARROW] = self.layer(SECOND, &wide);
        let (output, n) = (sample.output as usize, self.n_outputs);
        let weight = |i: usize| THIRD + i * n + output;
        let logit: f32 = (0..NARROW).map(|i| narrow[i] * self.numbers[weight(i)]).sum();
        let logit = logit + self.numbers[weight(NARROW)];
        let error = 1.0 / (1.0 + (-logit).exp()) - sample.is_so as u8 as f32;
        let mut to_narrow = [0.0; NARROW];
        for i in 0..NARROW {
            self.gradient[weight(i)] += error * narrow[i];
            to_narrow[i] = if narrow[i] > 0.0 { error * self.numbers[weight(i)] } else { 0.0 };
        }
        self.gradient[weight(NARROW)] += error;
        let to_wide = self.pass_back(SECOND, &wide, &to_narrow);
        self.pass_back(FIRST, &inputs, &to_wide);
    }

    /// The outputs of a hidden layer whose weights start at `start`.
    fn layer<const IN: usize, const OUT: usize>(&self, start: usize, inputs: &[f32; IN]) -> [f32; OUT] {
        let mut outputs = [0.0; OUT];
        outputs.copy_from_slice(&self.numbers[start + IN * OUT..][..OUT]);
        for (i, input) in inputs.iter().enumerate() {
            let weights = &self.numbers[start + i * OUT..][..OUT];
            outputs.iter_mut().zip(weights).for_each(|(output, weight)| *output += input * weight);
        }
        outputs.map(|output| output.max(0.0))
    }

    /// Adds the gradient of a layer's weights and returns that of its inputs; inputs that are 0 are skipped.
    fn pass_back<const IN: usize, const OUT: usize>(
        &mut self,
        start: usize,
        inputs: &[f32; IN],
        errors: &[f32; OUT],
    ) -> [f32; IN] {
        let mut to_inputs = [0.0; IN];
        for (i, &input) in inputs.iter().enumerate() {
            let row = start + i * OUT..start + (i + 1) * OUT;
            let gradient = self.gradient[row.clone()].iter_mut().zip(errors);
            gradient.for_each(|(gradient, error)| *gradient += input * error);
            if input > 0.0 {
                to_inputs[i] =
                    self.numbers[row].iter().zip(errors).map(|(weight, error)| weight * error).sum();
            }
        }
        let biases = self.gradient[start + IN * OUT..][..OUT].iter_mut().zip(errors);
        biases.for_each(|(gradient, error)| *gradient += error);
        to_inputs
    }

    /// Moves all weights against the gradient and resets it. Mean and scale of the features stay.
    fn step(&mut self, step: usize, length: f32) {
        let age = step as i32 + 1;
        let (mean_bias, square_bias) = (1.0 - 0.9_f32.powi(age), 1.0 - 0.999_f32.powi(age));
        for i in FIRST..self.numbers.len() {
            let gradient = std::mem::take(&mut self.gradient[i]) / BATCH as f32;
            self.mean[i] = 0.9 * self.mean[i] + 0.1 * gradient;
            self.square[i] = 0.999 * self.square[i] + 0.001 * gradient * gradient;
            let scale = (self.square[i] / square_bias).sqrt() + 1e-8;
            self.numbers[i] -= length * (self.mean[i] / mean_bias) / scale;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples(n: usize, seed: u64) -> Vec<VoxelSample> {
        let mut random = Random::new(seed, 0);
        let sample = |_| {
            let row = [(); N].map(|()| random.range(-2.0, 3.0) as f32);
            let output = random.index(2);
            // Not linearly separable.
            VoxelSample { row, output: output as u8, is_so: (row[0] * row[1] > 0.0) ^ (output == 1) }
        };
        (0..n).map(sample).collect()
    }

    #[test]
    fn learns_what_no_straight_line_divides() {
        let network = train(&samples(40_000, 1), 2, 4, 1);
        let held_out = loss(&network, 2, &samples(2000, 2));
        assert!(held_out < 0.35, "{held_out}: a coin has 0.69");
        assert_eq!(network, train(&samples(40_000, 1), 2, 4, 1), "the same seed gives the same bits");
    }

    /// The slow reference: differences of the loss, sample by sample. A unit may turn on or off between the
    /// two, so one in a hundred may differ.
    #[test]
    fn the_gradient_is_that_of_the_loss() {
        let (mut n_checked, mut n_wrong) = (0, 0);
        for sample in samples(20, 3) {
            let mut learner = Learner::new(&samples(50, 3), 2, &mut Random::new(4, 0));
            learner.learn(&sample);
            let loss_at = |numbers: &[f32]| loss(&Network::from_numbers(numbers, 2).unwrap(), 2, &[sample]);
            for i in (FIRST..learner.numbers.len()).step_by(37) {
                let moved = |by: f32| {
                    let mut numbers = learner.numbers.clone();
                    numbers[i] += by;
                    loss_at(&numbers)
                };
                let slope = (moved(4e-3) - moved(-4e-3)) / 8e-3;
                let gradient = learner.gradient[i] as f64;
                n_checked += 1;
                n_wrong += ((slope - gradient).abs() > 0.02 * gradient.abs() + 1e-3) as usize;
            }
        }
        assert!(n_checked > 500 && n_wrong * 100 < n_checked, "{n_wrong} of {n_checked}");
    }
}
