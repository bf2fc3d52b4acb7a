//! Text files written by other programs: with or without a byte order mark, and with Unix, Windows or old Mac
//! line endings.
//!
//! Every text reader passes its bytes through this module, so all accept the same files.

use crate::Error;
use std::borrow::Cow;

/// The byte order mark of UTF-8.
const MARK: &[u8] = b"\xEF\xBB\xBF";

/// Byte order marks of encodings other than UTF-8. UTF-32 comes first: its mark begins with that of UTF-16.
const OTHER_MARKS: [(&[u8], &str); 4] = [
    (b"\xFF\xFE\0\0", "UTF-32"),
    (b"\0\0\xFE\xFF", "UTF-32"),
    (b"\xFF\xFE", "UTF-16"),
    (b"\xFE\xFF", "UTF-16"),
];

/// Returns the bytes without the UTF-8 byte order mark. Fails if they begin like UTF-16 or UTF-32.
///
/// Use it for files that may be binary after a text header; for text, use [`plain`] or [`utf8`].
pub fn unmarked(bytes: &[u8]) -> Result<&[u8], Error> {
    let refused = |found: &str| {
        let problem = format!("is text in {found}, expected UTF-8; save it as UTF-8");
        Error::Format { place: "byte 0".to_owned(), problem }
    };
    if let Some((_, name)) = OTHER_MARKS.iter().find(|(mark, _)| bytes.starts_with(mark)) {
        return Err(refused(name));
    }
    // In those encodings, every ASCII character comes with a zero byte.
    if bytes.iter().take(4).any(|&byte| byte == 0) {
        return Err(refused("UTF-16 or UTF-32 without a byte order mark, or not text at all"));
    }
    Ok(bytes.strip_prefix(MARK).unwrap_or(bytes))
}

/// Returns the text without byte order mark, every line ending in a line feed, alone or after a carriage
/// return. Only ASCII matters here: comments may be in any encoding that extends ASCII.
///
/// Fails if the text is UTF-16 or UTF-32, or if a later line begins with a byte order mark.
///
/// ```
/// use nextview::text::plain;
///
/// assert_eq!(&*plain(b"\xEF\xBB\xBFv 1\rv 2\r\nv 3\n").unwrap(), b"v 1\nv 2\r\nv 3\n");
/// assert!(plain(b"\xFF\xFEv\0").unwrap_err().to_string().contains("UTF-16"));
/// ```
pub fn plain(bytes: &[u8]) -> Result<Cow<'_, [u8]>, Error> {
    let text = unmarked(bytes)?;
    let is_alone = |at: usize| text[at] == b'\r' && text.get(at + 1) != Some(&b'\n');
    let text = match (0..text.len()).find(|&at| is_alone(at)) {
        None => Cow::Borrowed(text),
        Some(first) => {
            let mut bytes = text.to_vec();
            (first..text.len()).filter(|&at| is_alone(at)).for_each(|at| bytes[at] = b'\n');
            Cow::Owned(bytes)
        }
    };
    match text.split(|&byte| byte == b'\n').position(|line| line.starts_with(MARK)) {
        Some(i) => {
            let problem = "begins with a byte order mark, expected one only at the start of a file; remove \
                           the marks before joining files"
                .to_owned();
            Err(Error::Format { place: format!("line {}", i + 1), problem })
        }
        None => Ok(text),
    }
}

/// Returns the [`plain`] text; fails unless it is UTF-8.
pub fn utf8(bytes: Vec<u8>) -> Result<String, Error> {
    let text = match plain(&bytes)? {
        // Most texts need no change.
        Cow::Borrowed(text) if text.len() == bytes.len() => bytes,
        text => text.into_owned(),
    };
    String::from_utf8(text).map_err(|error| {
        let offset = error.utf8_error().valid_up_to();
        let line = 1 + error.as_bytes()[..offset].iter().filter(|&&byte| byte == b'\n').count();
        Error::Format {
            place: format!("byte {offset} in line {line}"),
            problem: "is not UTF-8 text".to_owned(),
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn error(bytes: &[u8]) -> String {
        plain(bytes).unwrap_err().to_string()
    }

    #[test]
    fn marks_and_line_ends_are_no_part_of_a_text() {
        for (bytes, expected) in [
            (&b""[..], &b""[..]),
            (b"\xEF\xBB\xBF", b""),
            (b"a\rb\r\rc\r", b"a\nb\n\nc\n"),
            (b"\xEF\xBB\xBFa\r\nb\r\n", b"a\r\nb\r\n"),
            (b"# \xE4 in Latin-1\n", b"# \xE4 in Latin-1\n"),
        ] {
            assert_eq!(&*plain(bytes).unwrap(), expected);
        }
        assert!(matches!(plain(b"a\r\nb\n").unwrap(), Cow::Borrowed(_)), "the usual texts are not copied");
    }

    #[test]
    fn other_encodings_are_named() {
        assert!(error(b"\xFF\xFEv\0 \0").contains("is text in UTF-16, expected UTF-8"));
        assert!(error(b"\xFE\xFF\0v").contains("UTF-16,"));
        assert!(error(b"\xFF\xFE\0\0v\0\0\0").contains("UTF-32,"));
        assert!(error(b"\0\0\xFE\xFF\0\0\0v").contains("UTF-32,"));
        assert!(error(b"v\0 \0").contains("UTF-16 or UTF-32 without a byte order mark"));
        assert!(error(b"\0v\0 ").contains("UTF-16 or UTF-32 without a byte order mark"));
        assert!(error(b"v 1\r\xEF\xBB\xBFv 2\n").starts_with("line 2: begins with a byte order mark"));
        let latin = utf8(b"\xEF\xBB\xBFa\rb\xE4".to_vec()).unwrap_err().to_string();
        assert_eq!(latin, "byte 3 in line 2: is not UTF-8 text");
    }

    proptest! {
        #[test]
        fn every_line_end_gives_the_same_lines(lines in prop::collection::vec("[ a-z0-9äß]{0,9}", 1..9)) {
            let text = |end: &str| utf8(format!("\u{feff}{}", lines.join(end)).into_bytes()).unwrap();
            let expected = lines.join("\n");
            for end in ["\n", "\r", "\r\n"] {
                let text = text(end);
                prop_assert_eq!(text.lines().collect::<Vec<_>>(), expected.lines().collect::<Vec<_>>());
            }
        }
    }
}
