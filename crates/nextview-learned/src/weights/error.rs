/// Errors in a file of weights.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WeightsError {
    /// The file is not a safetensors file, or is damaged.
    #[error("{place}: {problem}")]
    Format {
        /// The byte offset or part of the file.
        place: String,
        /// The fault, and the expected content.
        problem: String,
    },
    /// A tensor of the network is missing.
    #[error("there is no tensor {name}, expected {expected}")]
    Missing {
        /// Its name.
        name: String,
        /// The expected shape.
        expected: TensorShape,
    },
    /// A tensor that the network does not have.
    #[error(
        "there is a tensor {name}, expected only those of {network}: weight and bias of {}",
        expected.join(", ")
    )]
    Unknown {
        /// Its name.
        name: String,
        /// The name of the network.
        network: &'static str,
        /// The names of its layers.
        expected: Vec<String>,
    },
    /// A tensor has another shape.
    #[error("the tensor {name} has the shape {found}, expected {expected}")]
    WrongShape {
        /// Its name.
        name: String,
        /// The shape in the file.
        found: TensorShape,
        /// The expected shape.
        expected: TensorShape,
    },
    /// A tensor has an unsupported number type.
    #[error("the tensor {name} is of type {found}, expected F32 or F16")]
    WrongType {
        /// Its name.
        name: String,
        /// Its type in the file.
        found: String,
    },
    /// A weight is NaN or infinite.
    #[error("number {index} (counted from 0) of the tensor {name} is {value}, expected finite numbers")]
    NotFinite {
        /// Name of the tensor.
        name: String,
        /// Index of the number in the tensor, from 0.
        index: usize,
        /// The number.
        value: f32,
    },
}

/// Lengths of a tensor's axes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TensorShape(pub Vec<usize>);

impl std::fmt::Display for TensorShape {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let axes: Vec<String> = self.0.iter().map(usize::to_string).collect();
        write!(f, "[{}]", axes.join(", "))
    }
}
