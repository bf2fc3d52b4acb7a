use std::borrow::Cow;

/// Returns a text as a field of CSV (RFC 4180): in quotes only where required.
pub fn csv_field(text: &str) -> Cow<'_, str> {
    if text.contains([',', '"', '\n', '\r']) {
        Cow::Owned(format!("\"{}\"", text.replace('"', "\"\"")))
    } else {
        Cow::Borrowed(text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_texts_that_need_quotes_get_them() {
        for (text, field) in
            [("", ""), ("a b", "a b"), ("a,b", "\"a,b\""), ("\"", "\"\"\"\""), ("a\rb", "\"a\rb\"")]
        {
            assert_eq!(csv_field(text), field);
        }
    }
}
