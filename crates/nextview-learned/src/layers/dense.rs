use crate::weights::Layer;

/// A fully connected layer.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Dense {
    /// Weights; those of an input are contiguous.
    weight: Vec<f32>,
    bias: Vec<f32>,
}

impl Dense {
    /// Creates a layer with these weights.
    pub fn new(layer: Layer) -> Self {
        let n_out = layer.bias.len();
        let n_in = layer.weight.len() / n_out;
        let weight = (0..n_in * n_out).map(|i| layer.weight[i % n_out * n_in + i / n_out]).collect();
        Self { weight, bias: layer.bias }
    }

    /// Returns the number of outputs.
    pub fn n_outputs(&self) -> usize {
        self.bias.len()
    }

    /// Appends the outputs for these inputs: for each the bias and then, in order, the contribution of each
    /// input.
    #[inline(always)]
    #[allow(
        clippy::needless_range_loop,
        reason = "iterators are not always inlined into vector instructions"
    )]
    pub fn append(&self, inputs: &[f32], outputs: &mut Vec<f32>) {
        let n = self.n_outputs();
        let begin = outputs.len();
        outputs.extend_from_slice(&self.bias);
        let outputs = &mut outputs[begin..];
        for (input, weights) in inputs.iter().zip(self.weight.chunks_exact(n)) {
            for output in 0..n {
                outputs[output] += input * weights[output];
            }
        }
    }

    /// Returns the outputs of all rows of `n_in` inputs each, one row after the other.
    #[inline(always)]
    pub fn rows(&self, inputs: &[f32], n_in: usize) -> Vec<f32> {
        let mut outputs = Vec::with_capacity(inputs.len() / n_in * self.n_outputs());
        for row in inputs.chunks_exact(n_in) {
            self.append(row, &mut outputs);
        }
        outputs
    }

    /// Returns the weights, mutable for tests.
    #[cfg(test)]
    pub fn weight_mut(&mut self) -> &mut [f32] {
        &mut self.weight
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// The slow reference, by definition.
    pub fn slow_dense(inputs: &[f32], layer: &Layer) -> Vec<f32> {
        let output = |(o, &bias): (usize, &f32)| {
            let weights = &layer.weight[o * inputs.len()..];
            inputs.iter().zip(weights).fold(bias, |sum, (input, weight)| sum + input * weight)
        };
        layer.bias.iter().enumerate().map(output).collect()
    }

    #[test]
    fn rows_are_what_the_definition_says() {
        let layer = Layer { weight: vec![1.0, 2.0, 3.0, -1.0, 0.5, 0.25], bias: vec![10.0, 20.0] };
        let found = Dense::new(layer.clone()).rows(&[1.0, 1.0, 1.0, 2.0, 0.0, 4.0], 3);
        assert_eq!(found, [16.0, 19.75, 24.0, 19.0]);
        let twin = [[1.0, 1.0, 1.0], [2.0, 0.0, 4.0]].map(|row| slow_dense(&row, &layer));
        assert_eq!(found, twin.concat());
    }
}
