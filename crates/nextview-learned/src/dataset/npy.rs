//! NumPy's file format, version 1.0, for an array of records.

use super::NetworkName;
use super::sample::TrainingSample;
use std::io::{self, Write};

/// Writes the samples as an array for `numpy.load`.
pub(super) fn write(
    writer: &mut impl Write,
    network: NetworkName,
    samples: &[TrainingSample],
) -> io::Result<()> {
    writer.write_all(&header(network, samples.len()))?;
    for sample in samples {
        writer.write_all(&sample.object.to_le_bytes())?;
        writer.write_all(&[sample.n_views, sample.label])?;
        for number in sample.seen.iter().chain(&sample.gains) {
            writer.write_all(&number.to_le_bytes())?;
        }
        writer.write_all(&sample.input)?;
    }
    Ok(())
}

/// The header, which ends at a multiple of 64 bytes.
fn header(network: NetworkName, n: usize) -> Vec<u8> {
    let (v, input) = (network.directions().len(), network.input_fields());
    let mut text = format!(
        "{{'descr': [('object', '<u4'), ('n_views', '|u1'), ('label', '|u1'), ('seen', '<u4', ({v},)), \
         ('gains', '<u4', ({v},)), {input}], 'fortran_order': False, 'shape': ({n},), }}"
    );
    let before = MAGIC.len() + size_of::<u16>();
    let length = (before + text.len() + 1).next_multiple_of(64) - before;
    text += &" ".repeat(length - text.len() - 1);
    text.push('\n');
    [MAGIC, &(length as u16).to_le_bytes(), text.as_bytes()].concat()
}

const MAGIC: &[u8] = b"\x93NUMPY\x01\x00";

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Grid;
    use crate::nbv_net::views;

    #[test]
    fn the_header_is_as_the_format_says() {
        for n in [0, 7, 100_000] {
            let header = header(NetworkName::PcNbv, n);
            assert_eq!(header.len() % 64, 0);
            assert_eq!(&header[..8], b"\x93NUMPY\x01\x00");
            assert_eq!(u16::from_le_bytes([header[8], header[9]]) as usize, header.len() - 10);
            assert_eq!(header.last(), Some(&b'\n'));
            let text = String::from_utf8(header[10..].to_vec()).unwrap();
            assert!(text.contains(&format!("'shape': ({n},)")));
        }
    }

    #[test]
    fn records_are_as_long_as_the_header_says() {
        let sample = TrainingSample {
            object: 0x0403_0201,
            n_views: 5,
            label: 6,
            seen: vec![7; views::N_VIEWS],
            gains: vec![8; views::N_VIEWS],
            input: vec![9; Grid::N_CELLS],
        };
        let mut bytes = Vec::new();
        write(&mut bytes, NetworkName::NbvNet, &[sample.clone(), sample]).unwrap();
        let record = 4 + 2 + 2 * 4 * views::N_VIEWS + Grid::N_CELLS;
        let start = header(NetworkName::NbvNet, 2).len();
        assert_eq!(bytes.len(), start + 2 * record);
        assert_eq!(bytes[start..start + 8], [1, 2, 3, 4, 5, 6, 7, 0]);
        assert_eq!(bytes[start + record - 1..][..2], [9, 1]);
    }
}
