use super::cursor::Cursor;
use crate::{RecordingError, limits};
use std::io::Read;

/// Decompresses the records of a chunk.
pub(super) fn records(content: &[u8]) -> Result<Vec<u8>, RecordingError> {
    let mut cursor = Cursor::new(content);
    cursor.take(8 + 8)?; // times of the first and the last message
    let size = u64::from_le_bytes(cursor.array()?);
    let crc = u32::from_le_bytes(cursor.array()?);
    let compression = cursor.text()?;
    let length = u64::from_le_bytes(cursor.array()?);
    let packed = cursor.take(usize::try_from(length).unwrap_or(usize::MAX))?;
    limits::check_chunk(size, length)?;
    let plain = decompressed(compression, packed, size)?;
    let found = crc32fast::hash(&plain);
    if plain.len() as u64 != size || (crc != 0 && crc != found) {
        return Err(RecordingError::Content(format!(
            "a chunk is damaged: {} bytes with checksum {found:08x}, expected {size} with {crc:08x}",
            plain.len()
        )));
    }
    Ok(plain)
}

/// Decompresses at most one byte more than `size`, however large the content.
fn decompressed(compression: &str, packed: &[u8], size: u64) -> Result<Vec<u8>, RecordingError> {
    let damaged = |error: String| {
        RecordingError::Content(format!("a chunk cannot be decompressed ({compression}): {error}"))
    };
    let mut plain = Vec::new();
    let limit = size.saturating_add(1);
    match compression {
        "" => plain.extend_from_slice(packed),
        "zstd" => {
            let decoder = ruzstd::decoding::StreamingDecoder::new(packed);
            let mut decoder = decoder.map_err(|error| damaged(error.to_string()))?.take(limit);
            decoder.read_to_end(&mut plain).map_err(|error| damaged(error.to_string()))?;
        }
        "lz4" => {
            let mut decoder = lz4_flex::frame::FrameDecoder::new(packed).take(limit);
            decoder.read_to_end(&mut plain).map_err(|error| damaged(error.to_string()))?;
        }
        other => {
            let problem =
                format!("a chunk is compressed with '{other}', expected zstd, lz4 or no compression");
            return Err(RecordingError::Content(problem));
        }
    }
    Ok(plain)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chunk(compression: &str, packed: &[u8], plain: &[u8]) -> Vec<u8> {
        let mut chunk = vec![0; 16];
        chunk.extend((plain.len() as u64).to_le_bytes());
        chunk.extend(crc32fast::hash(plain).to_le_bytes());
        chunk.extend((compression.len() as u32).to_le_bytes());
        chunk.extend(compression.as_bytes());
        chunk.extend((packed.len() as u64).to_le_bytes());
        chunk.extend(packed);
        chunk
    }

    fn packed(compression: &str, plain: &[u8]) -> Vec<u8> {
        match compression {
            "zstd" => ruzstd::encoding::compress_to_vec(plain, ruzstd::encoding::CompressionLevel::Fastest),
            "lz4" => {
                let mut encoder = lz4_flex::frame::FrameEncoder::new(Vec::new());
                std::io::Write::write_all(&mut encoder, plain).unwrap();
                encoder.finish().unwrap()
            }
            _ => plain.to_vec(),
        }
    }

    #[test]
    fn chunks_are_unpacked_and_checked() {
        let plain: Vec<u8> = (0..50_000_u32).map(|i| ((i * i) >> 7) as u8).collect();
        for compression in ["", "zstd", "lz4"] {
            let packed = packed(compression, &plain);
            assert_eq!(records(&chunk(compression, &packed, &plain)).unwrap(), plain);
            let error = |packed: &[u8], plain: &[u8]| {
                records(&chunk(compression, packed, plain)).unwrap_err().to_string()
            };
            assert!(error(&packed, &plain[1..]).contains("a chunk is damaged"), "{compression}");
            assert!(error(&packed[..packed.len() / 2], &plain).contains("a chunk"), "{compression}");
            assert!(records(&chunk(compression, &packed, &plain)[..60]).is_err());
        }
        assert!(records(&chunk("xz", &[], &[])).unwrap_err().to_string().contains("compressed with 'xz'"));
    }
}
