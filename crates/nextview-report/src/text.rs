//! Common parts of all pages: the style, escaping, templates, numbers with units.

/// The style of all pages.
pub(crate) const STYLE: &str = include_str!("style.css");

/// Separates digits and units without a line break.
const NARROW_SPACE: char = '\u{202f}';

/// Escapes text for use inside an element or a quoted attribute.
pub fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            c => out.push(c),
        }
    }
    out
}

/// Replaces `{{name}}` with values in one pass: a value that contains `{{...}}` stays unchanged.
pub fn fill(template: &str, values: &[(&str, String)]) -> String {
    let mut parts = template.split("{{");
    let mut out = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let (name, rest) = part.split_once("}}").expect("the template closes every {{");
        let value = values.iter().find(|(n, _)| *n == name);
        out.push_str(&value.expect("the template names only known values").1);
        out.push_str(rest);
    }
    out
}

/// Formats a share in 0..=1 as "97.1 %"; a dash if it is not a number.
pub fn percent(share: f64) -> String {
    with_unit(100.0 * share, 1, "%")
}

/// Formats a length in metres.
pub fn metres(length: f64) -> String {
    with_unit(length, 2, "m")
}

/// Formats a time in seconds, in milliseconds below one second.
pub fn seconds(time: f64) -> String {
    match time {
        t if t < 0.01 => with_unit(1e3 * t, 1, "ms"),
        t if t < 1.0 => with_unit(1e3 * t, 0, "ms"),
        t => with_unit(t, 2, "s"),
    }
}

/// Formats a whole number in groups of three digits.
pub fn count(n: usize) -> String {
    let digits = n.to_string();
    let mut out = String::new();
    for (i, c) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push(NARROW_SPACE);
        }
        out.push(c);
    }
    out
}

/// A number with this number of decimals; a dash if it is too large or NaN.
pub(crate) fn fixed(value: f64, decimals: usize) -> String {
    // Plus zero turns the negative zero of an empty sum into zero.
    if value.is_finite() { format!("{:.decimals$}", value + 0.0) } else { "–".to_owned() }
}

fn with_unit(value: f64, decimals: usize, unit: &str) -> String {
    match value.is_finite() {
        true => format!("{}{NARROW_SPACE}{unit}", fixed(value, decimals)),
        false => fixed(value, decimals),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn escapes_all_that_html_reads() {
        assert_eq!(escape(r#"<a href="x">'&'</a>"#), "&lt;a href=&quot;x&quot;&gt;&#39;&amp;&#39;&lt;/a&gt;");
    }

    #[test]
    fn a_value_is_not_a_template() {
        let values = [("a", "{{b}}".to_owned()), ("b", "x".to_owned())];
        assert_eq!(fill("1{{a}}2{{b}}3", &values), "1{{b}}2x3");
    }

    #[test]
    fn numbers_carry_units() {
        let plain = |s: String| s.replace(NARROW_SPACE, " ");
        assert_eq!(plain(percent(0.9714)), "97.1 %");
        assert_eq!(percent(f64::NAN), "–");
        assert_eq!([fixed(f64::INFINITY, 1), fixed(-0.0, 1)], ["–", "0.0"]);
        assert_eq!(plain(seconds(0.0042)), "4.2 ms");
        assert_eq!(plain(seconds(0.042)), "42 ms");
        assert_eq!(plain(seconds(1.5)), "1.50 s");
        assert_eq!(plain(count(1_234_567)), "1 234 567");
        assert_eq!(count(123), "123");
    }
}
