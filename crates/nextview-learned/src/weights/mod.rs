//! Reads weights from the safetensors format: eight bytes with the length of a header, the header in JSON,
//! and numbers.
//!
//! The reader is our own, since the checks are its main part and the format takes a few lines: its authors'
//! crate would add more than it saves.

mod error;

pub use error::{TensorShape, WeightsError};

use half::f16;
use serde::Deserialize;
use std::collections::BTreeMap;

/// The weights of a layer in PyTorch's order: those of an output are contiguous.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Layer {
    pub weight: Vec<f32>,
    pub bias: Vec<f32>,
}

/// The layers of a network. A file of its weights has the tensors `weight` and `bias` of each.
#[derive(Clone, Debug)]
pub(crate) struct NetworkLayout {
    /// Its name.
    pub network: &'static str,
    /// Names of the layers, from the first to the last, and the shapes of their weights.
    pub layers: Vec<(String, Vec<usize>)>,
}

/// A tensor as the header describes it.
#[derive(Debug, Deserialize)]
struct TensorEntry {
    dtype: String,
    shape: Vec<usize>,
    /// Offsets of its first byte and of the end of its data, counted from the end of the header.
    data_offsets: [usize; 2],
}

/// Maximum header length, bytes: thirty times that of the network with the most layers.
const MAX_HEADER: u64 = 100_000;

/// The layers of a network, from the first to the last.
pub(crate) fn read(file: &[u8], layout: &NetworkLayout) -> Result<Vec<Layer>, WeightsError> {
    let (mut entries, data) = split(file)?;
    let mut take = |name: String, shape: Vec<usize>| {
        let expected = TensorShape(shape);
        match entries.remove(&name) {
            Some(entry) => numbers(name, entry, expected, data),
            None => Err(WeightsError::Missing { name, expected }),
        }
    };
    let mut layers = Vec::new();
    for (name, shape) in &layout.layers {
        let bias = take(format!("{name}.bias"), vec![shape[0]])?;
        layers.push(Layer { weight: take(format!("{name}.weight"), shape.clone())?, bias });
    }
    match entries.into_keys().next() {
        Some(name) => {
            let expected = layout.layers.iter().map(|(name, _)| name.clone()).collect();
            Err(WeightsError::Unknown { name, network: layout.network, expected })
        }
        None => Ok(layers),
    }
}

/// The tensors in the header, and the bytes after it.
fn split(file: &[u8]) -> Result<(BTreeMap<String, TensorEntry>, &[u8]), WeightsError> {
    let (length, rest) = file.split_first_chunk().ok_or_else(|| {
        format_error(format!("byte {}", file.len()), "the file ends, expected a safetensors file".to_owned())
    })?;
    let length = u64::from_le_bytes(*length);
    if length > MAX_HEADER {
        let problem = format!(
            "the header has {length} bytes, expected at most {MAX_HEADER}: is this a safetensors file?"
        );
        return Err(format_error("byte 0", problem));
    }
    let (header, data) = rest.split_at_checked(length as usize).ok_or_else(|| {
        format_error(
            "the header",
            format!("has only {} of {length} bytes: the file is truncated", rest.len()),
        )
    })?;
    let bad = |e: serde_json::Error| format_error("the header", format!("is not a table of tensors: {e}"));
    let mut table: BTreeMap<String, serde_json::Value> = serde_json::from_slice(header).map_err(bad)?;
    table.remove("__metadata__");
    let entries = table.into_iter().map(|(name, value)| {
        let entry = serde_json::from_value(value);
        Ok((name.clone(), entry.map_err(|e| format_error(format!("the tensor {name}"), e.to_string()))?))
    });
    Ok((entries.collect::<Result<_, _>>()?, data))
}

/// The numbers of a tensor, which must be finite and match the expected shape.
fn numbers(
    name: String,
    entry: TensorEntry,
    expected: TensorShape,
    data: &[u8],
) -> Result<Vec<f32>, WeightsError> {
    let found = TensorShape(entry.shape);
    if found != expected {
        return Err(WeightsError::WrongShape { name, found, expected });
    }
    let (size, number): (usize, fn(&[u8]) -> f32) = match entry.dtype.as_str() {
        "F32" => (4, |bytes| f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])),
        "F16" => (2, |bytes| f16::from_le_bytes([bytes[0], bytes[1]]).to_f32()),
        _ => return Err(WeightsError::WrongType { name, found: entry.dtype }),
    };
    let [begin, end] = entry.data_offsets;
    let place = || format!("the tensor {name}");
    let bytes = data.get(begin..end).ok_or_else(|| {
        let n = data.len();
        format_error(
            place(),
            format!("has the bytes {begin} to {end}, but there are only {n}: the file is truncated"),
        )
    })?;
    let needed = size * expected.0.iter().product::<usize>();
    if bytes.len() != needed {
        return Err(format_error(place(), format!("has {} bytes, expected {needed}", bytes.len())));
    }
    let numbers: Vec<f32> = bytes.chunks_exact(size).map(number).collect();
    match numbers.iter().position(|number| !number.is_finite()) {
        Some(index) => Err(WeightsError::NotFinite { name, index, value: numbers[index] }),
        None => Ok(numbers),
    }
}

fn format_error(place: impl Into<String>, problem: String) -> WeightsError {
    WeightsError::Format { place: place.into(), problem }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use nextview::geometry::random::Random;

    /// A tensor of a synthetic file: its name, type, shape and bytes.
    type Tensor = (String, &'static str, Vec<usize>, Vec<u8>);

    /// Returns the tensors of such a network with small random weights, in single precision.
    pub fn tensors(seed: u64, layout: &NetworkLayout) -> Vec<Tensor> {
        let mut random = Random::new(seed, 0);
        let mut tensor = |name: String, shape: Vec<usize>, bound: f64| {
            let n = shape.iter().product();
            let numbers: Vec<f32> = (0..n).map(|_| random.range(-bound, bound) as f32).collect();
            (name, "F32", shape, numbers.iter().flat_map(|number| number.to_le_bytes()).collect())
        };
        let layers = layout.layers.iter().flat_map(|(name, shape)| {
            // This bound keeps the magnitude of the values about constant from layer to layer.
            let bound = (6.0 / shape[1..].iter().product::<usize>() as f64).sqrt();
            let bias = tensor(format!("{name}.bias"), vec![shape[0]], 0.1);
            [tensor(format!("{name}.weight"), shape.clone(), bound), bias]
        });
        layers.collect()
    }

    pub fn file(tensors: &[Tensor]) -> Vec<u8> {
        let mut header = serde_json::Map::new();
        header.insert("__metadata__".to_owned(), serde_json::json!({ "format": "pt" }));
        let mut data = Vec::new();
        for (name, dtype, shape, bytes) in tensors {
            let offsets = [data.len(), data.len() + bytes.len()];
            let entry = serde_json::json!({ "dtype": dtype, "shape": shape, "data_offsets": offsets });
            header.insert(name.clone(), entry);
            data.extend(bytes);
        }
        let header = serde_json::to_vec(&header).unwrap();
        [&(header.len() as u64).to_le_bytes()[..], &header, &data].concat()
    }

    fn nbv_net() -> NetworkLayout {
        crate::nbv_net::layout()
    }

    /// The error message for the tensors of seed 0 after a change.
    fn refusal(change: impl FnOnce(&mut Vec<Tensor>)) -> String {
        let mut tensors = tensors(0, &nbv_net());
        change(&mut tensors);
        read(&file(&tensors), &nbv_net()).unwrap_err().to_string()
    }

    #[test]
    fn reads_single_and_half_precision_in_any_order() {
        let mut tensors = tensors(1, &nbv_net());
        let layers = read(&file(&tensors), &nbv_net()).unwrap();
        assert_eq!(
            layers.iter().map(|layer| layer.bias.len()).collect::<Vec<_>>(),
            [10, 12, 8, 1500, 500, 100, 50, 14]
        );
        assert_eq!(layers.iter().map(|l| l.weight.len() + l.bias.len()).sum::<usize>(), 1_581_996);
        tensors.reverse();
        assert_eq!(read(&file(&tensors), &nbv_net()).unwrap(), layers);
        for (_, dtype, _, bytes) in &mut tensors {
            let numbers = bytes.chunks_exact(4).map(|b| f32::from_le_bytes(b.try_into().unwrap()));
            (*dtype, *bytes) = ("F16", numbers.flat_map(|x| f16::from_f32(x).to_le_bytes()).collect());
        }
        let halved = read(&file(&tensors), &nbv_net()).unwrap();
        for (half, single) in halved.iter().zip(&layers) {
            let pairs = half.weight.iter().zip(&single.weight).chain(half.bias.iter().zip(&single.bias));
            pairs.for_each(|(a, b)| assert!((a - b).abs() <= 5e-4 * b.abs() + 1e-7, "{a} {b}"));
        }
    }

    #[test]
    fn says_which_tensor_is_wrong() {
        assert_eq!(
            refusal(|tensors| tensors[0].2 = vec![10, 1, 3, 9]),
            "the tensor conv1.weight has the shape [10, 1, 3, 9], expected [10, 1, 3, 3, 3]"
        );
        let missing = refusal(|tensors| tensors.retain(|tensor| tensor.0 != "fc2.bias"));
        assert_eq!(missing, "there is no tensor fc2.bias, expected [500]");
        let more = refusal(|tensors| tensors.push(("fc6.bias".to_owned(), "F32", vec![1], vec![0; 4])));
        assert!(more.starts_with("there is a tensor fc6.bias, expected only those of NBV-Net"));
        let dtype = refusal(|tensors| tensors[3].1 = "I64");
        assert_eq!(dtype, "the tensor conv2.bias is of type I64, expected F32 or F16");
        let short = refusal(|tensors| tensors[2].3.truncate(400));
        assert_eq!(short, "the tensor conv2.weight: has 400 bytes, expected 12960");
        for (bytes, value) in [(f32::NAN.to_le_bytes(), "NaN"), (f32::INFINITY.to_le_bytes(), "inf")] {
            let not_finite = refusal(|tensors| tensors[5].3[28..32].copy_from_slice(&bytes));
            let expected = "(counted from 0) of the tensor conv3.bias is";
            assert_eq!(not_finite, format!("number 7 {expected} {value}, expected finite numbers"));
        }
        let not_finite = refusal(|tensors| {
            (tensors[1].1, tensors[1].3) = ("F16", f16::NAN.to_le_bytes().repeat(10));
        });
        assert!(not_finite.contains("number 0 (counted from 0) of the tensor conv1.bias is NaN"));
    }

    #[test]
    fn says_where_a_file_is_damaged() {
        let whole = file(&tensors(2, &nbv_net()));
        let message = |bytes: &[u8]| read(bytes, &nbv_net()).unwrap_err().to_string();
        for (n, expected) in
            [(0, "byte 0: the file ends"), (7, "byte 7: the file ends"), (500, "the header: has only 492 of")]
        {
            assert!(message(&whole[..n]).contains(expected), "{n}: {}", message(&whole[..n]));
        }
        assert!(message(&whole[..whole.len() - 1]).contains("the file is truncated"));
        assert!(message(b"PK\x03\x04 a zip file, as .pth is").contains("is this a safetensors file?"));
        let with_header =
            |header: &[u8]| message(&[&(header.len() as u64).to_le_bytes()[..], header].concat());
        assert!(with_header(b"{").starts_with("the header: is not a table of tensors: "));
        assert!(with_header(b"[]").starts_with("the header: is not a table of tensors: "));
        assert!(with_header(b"{}").starts_with("there is no tensor conv1.bias"));
        assert!(with_header(br#"{"fc1.bias": 3}"#).starts_with("the tensor fc1.bias: invalid type"));
        let backwards = br#"{"conv1.bias": {"dtype": "F32", "shape": [10], "data_offsets": [40, 0]}}"#;
        assert!(with_header(backwards).contains("the bytes 40 to 0, but there are only 0"));
    }
}
