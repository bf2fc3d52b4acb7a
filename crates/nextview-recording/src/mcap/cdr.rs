//! The encoding of ROS 2 messages: CDR (OMG formal/02-06-51, 15.3), each number aligned to its own size.

use super::cursor::Cursor;
use crate::RecordingError;

/// Reads the values of a message.
#[derive(Debug)]
pub(super) struct Cdr<'a> {
    /// Starts after the four bytes of the encoding header, where alignment begins.
    cursor: Cursor<'a>,
    is_little_endian: bool,
}

impl<'a> Cdr<'a> {
    /// Begins a message. Fails if it is not in plain CDR.
    pub fn new(message: &'a [u8]) -> Result<Self, RecordingError> {
        let mut head = Cursor::new(message);
        let is_little_endian = match head.array::<4>()? {
            [0, 0, ..] => false,
            [0, 1, ..] => true,
            [a, b, ..] => {
                let problem =
                    format!("the message's encoding is {a:02x} {b:02x}, expected plain CDR, 00 00 or 00 01");
                return Err(RecordingError::Content(problem));
            }
        };
        Ok(Self { cursor: Cursor::new(head.rest()), is_little_endian })
    }

    pub fn u8(&mut self) -> Result<u8, RecordingError> {
        self.number().map(u8::from_le_bytes)
    }

    pub fn u32(&mut self) -> Result<u32, RecordingError> {
        self.number().map(u32::from_le_bytes)
    }

    pub fn i32(&mut self) -> Result<i32, RecordingError> {
        self.number().map(i32::from_le_bytes)
    }

    pub fn f64(&mut self) -> Result<f64, RecordingError> {
        self.number().map(f64::from_le_bytes)
    }

    /// Reads a fixed number of values.
    pub fn f64s<const N: usize>(&mut self) -> Result<[f64; N], RecordingError> {
        let mut values = [0.0; N];
        for value in &mut values {
            *value = self.f64()?;
        }
        Ok(values)
    }

    /// Reads a list of numbers, preceded by its length.
    pub fn f64_list(&mut self) -> Result<Vec<f64>, RecordingError> {
        let length = self.u32()?;
        // Lengths are not trusted for reserving memory: reading fails at the end of the message.
        (0..length).map(|_| self.f64()).collect()
    }

    /// Reads bytes, preceded by their number.
    pub fn bytes(&mut self) -> Result<&'a [u8], RecordingError> {
        let length = self.u32()?;
        self.cursor.take(length as usize)
    }

    /// Reads a text, preceded by its length including the final zero.
    pub fn text(&mut self) -> Result<&'a str, RecordingError> {
        let bytes = self.bytes()?;
        let text = bytes.strip_suffix(&[0]).unwrap_or(bytes);
        str::from_utf8(text).map_err(|_| RecordingError::Content("a string is not UTF-8".into()))
    }

    /// Reads the bytes of a number, lowest first.
    fn number<const N: usize>(&mut self) -> Result<[u8; N], RecordingError> {
        self.cursor.take(self.cursor.at().next_multiple_of(N) - self.cursor.at())?;
        let mut bytes = self.cursor.array()?;
        if !self.is_little_endian {
            bytes.reverse();
        }
        Ok(bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn numbers_are_aligned_after_the_head_and_of_either_order() {
        let little = [0, 1, 0, 0, 7, 0, 0, 0, 1, 0, 0, 0, 3, 0, 0, 0, b'h', b'i', 0, 9];
        let big = [0, 0, 0, 0, 7, 9, 9, 9, 0, 0, 0, 1, 0, 0, 0, 3, b'h', b'i', 0, 9];
        for message in [little, big] {
            let mut cdr = Cdr::new(&message).unwrap();
            assert_eq!((cdr.u8().unwrap(), cdr.u32().unwrap(), cdr.text().unwrap()), (7, 1, "hi"));
            assert_eq!(cdr.u8().unwrap(), 9);
            assert!(
                cdr.u8().unwrap_err().to_string().contains("byte 16: 1 bytes expected, but only 0 are left")
            );
        }
        let mut message = vec![0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0];
        message.extend(2.5_f64.to_le_bytes());
        let mut cdr = Cdr::new(&message).unwrap();
        assert_eq!((cdr.i32().unwrap(), cdr.f64s::<1>().unwrap()), (1, [2.5]));
        assert!(Cdr::new(&[0, 7, 0, 0]).unwrap_err().to_string().contains("encoding is 00 07"));
        assert!(Cdr::new(&[0, 1]).is_err());
    }

    proptest! {
        #[test]
        fn never_panics(bytes in prop::collection::vec(any::<u8>(), 0..60), order in 0..2_u8, reads in prop::collection::vec(0..6, 0..20)) {
            let message = [&[0, order, 0, 0], &bytes[..]].concat();
            let mut cdr = Cdr::new(&message).unwrap();
            for read in reads {
                let is_read = match read {
                    0 => cdr.u8().is_ok(),
                    1 => cdr.u32().is_ok(),
                    2 => cdr.f64().is_ok(),
                    3 => cdr.text().is_ok(),
                    4 => cdr.bytes().is_ok(),
                    _ => cdr.f64_list().is_ok(),
                };
                prop_assert!(is_read || cdr.cursor.at() <= bytes.len());
            }
        }
    }
}
