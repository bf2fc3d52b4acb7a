//! The binary data of a document: buffers and the arrays in them.

use super::json::{Buffer, GltfDocument, field};
use crate::SimError;
use crate::mesh::image::Resolve;
use std::borrow::Cow;

/// The data of every buffer.
pub(super) fn load<'a>(
    document: &GltfDocument,
    chunk: Option<&'a [u8]>,
    resolve: &Resolve,
) -> Result<Vec<Cow<'a, [u8]>>, SimError> {
    document.buffers.iter().enumerate().map(|(i, buffer)| load_one(i, buffer, chunk, resolve)).collect()
}

fn load_one<'a>(
    i: usize,
    buffer: &Buffer,
    chunk: Option<&'a [u8]>,
    resolve: &Resolve,
) -> Result<Cow<'a, [u8]>, SimError> {
    let place = format!("buffers[{i}]");
    let data: Cow<[u8]> = match &buffer.uri {
        None => chunk
            .ok_or_else(|| SimError::format(&place, "has no uri, and the file has no binary chunk"))?
            .into(),
        Some(uri) => of_uri(&place, uri, resolve)?.into(),
    };
    if data.len() < buffer.byte_length {
        let problem =
            format!("has {} bytes, expected {}; the data is truncated", data.len(), buffer.byte_length);
        return Err(SimError::format(place, problem));
    }
    Ok(data)
}

/// The data a URI stands for: embedded, or a file.
pub(super) fn of_uri(place: &str, uri: &str, resolve: &Resolve) -> Result<Vec<u8>, SimError> {
    match uri.strip_prefix("data:") {
        Some(inline) => {
            let text = inline.split_once(";base64,").map(|(_, text)| text);
            let decoded = text.and_then(|text| decode_base64(text.as_bytes()));
            decoded.ok_or_else(|| SimError::format(place, "has a data URI that is not valid base64"))
        }
        None => resolve(uri).map_err(|error| SimError::format(place, format!("{uri:?}: {error}"))),
    }
}

/// The bytes of buffer view `i`.
pub(super) fn view<'a>(
    document: &GltfDocument,
    buffers: &'a [Cow<[u8]>],
    i: usize,
) -> Result<&'a [u8], SimError> {
    let view = field(&document.buffer_views, i, "bufferViews")?;
    let bytes = buffers.get(view.buffer).and_then(|buffer| slice(buffer, view.byte_offset, view.byte_length));
    bytes.ok_or_else(|| SimError::format(format!("bufferViews[{i}]"), "lies outside its buffer"))
}

/// The elements of accessor `i`, each as the bytes of `n_components` numbers of `component_size` bytes.
pub(super) fn elements<'a>(
    document: &GltfDocument,
    buffers: &'a [Cow<[u8]>],
    i: usize,
    element_size: usize,
) -> Result<impl ExactSizeIterator<Item = &'a [u8]> + use<'a>, SimError> {
    let accessor = field(&document.accessors, i, "accessors")?;
    let error = |problem: &str| SimError::format(format!("accessors[{i}]"), problem);
    let (Some(view), None) = (accessor.buffer_view, &accessor.sparse) else {
        return Err(error(
            "is sparse or has no bufferView, which is not supported; export the mesh without sparse accessors",
        ));
    };
    let view = field(&document.buffer_views, view, "bufferViews")?;
    let buffer = buffers.get(view.buffer).ok_or_else(|| error("refers to a buffer that does not exist"))?;
    let stride = view.byte_stride.unwrap_or(element_size);
    if stride < element_size {
        return Err(error(&format!(
            "has a stride of {stride} bytes, less than an element of {element_size}"
        )));
    }
    let bytes = slice(buffer, view.byte_offset, view.byte_length)
        .and_then(|view| view.get(accessor.byte_offset..))
        .ok_or_else(|| error("lies outside its buffer"))?;
    let n_available = if bytes.len() < element_size { 0 } else { (bytes.len() - element_size) / stride + 1 };
    if accessor.count > n_available {
        return Err(error(&format!(
            "has {} elements, but its buffer holds only {n_available}",
            accessor.count
        )));
    }
    Ok((0..accessor.count).map(move |k| &bytes[k * stride..k * stride + element_size]))
}

fn slice(bytes: &[u8], offset: usize, length: usize) -> Option<&[u8]> {
    bytes.get(offset..offset.checked_add(length)?)
}

/// Base64 (RFC 4648), with or without padding.
fn decode_base64(text: &[u8]) -> Option<Vec<u8>> {
    let digits = text.trim_ascii().strip_suffix(b"==").or(text.trim_ascii().strip_suffix(b"="));
    let mut bytes = Vec::new();
    for group in digits.unwrap_or(text.trim_ascii()).chunks(4) {
        let mut bits = 0_u32;
        for &digit in group {
            bits = bits << 6 | base64_digit(digit)?;
        }
        let n_bytes = group.len() * 6 / 8;
        bits <<= 6 * (4 - group.len());
        bytes.extend_from_slice(&bits.to_be_bytes()[1..1 + n_bytes]);
    }
    Some(bytes)
}

fn base64_digit(digit: u8) -> Option<u32> {
    let value = match digit {
        b'A'..=b'Z' => digit - b'A',
        b'a'..=b'z' => digit - b'a' + 26,
        b'0'..=b'9' => digit - b'0' + 52,
        b'+' => 62,
        b'/' => 63,
        _ => return None,
    };
    Some(value as u32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decodes_base64() {
        for (text, expected) in
            [("", ""), ("Zg==", "f"), ("Zm8=", "fo"), ("Zm9v", "foo"), ("Zm9vYmE", "fooba")]
        {
            assert_eq!(decode_base64(text.as_bytes()).as_deref(), Some(expected.as_bytes()));
        }
        assert_eq!(decode_base64(b"Zm 9"), None);
    }
}
