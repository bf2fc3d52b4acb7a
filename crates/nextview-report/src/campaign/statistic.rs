//! Cells with a mean, its interval, its median and a test. A missing number is a dash with the reason.

use super::document::Cell;
use nextview_campaign::statistics::{Interval, Measure, Sample, SignedRank};

/// The reason for an empty cell if runs have no such number.
pub(super) const NOT_MEASURED: &str = "not measured";

/// A dash with the reason.
pub(super) fn dash(reason: &str) -> Cell {
    Cell::with_note("–", reason)
}

/// Mean of the sample, with its interval and the median if there are several objects or runs.
pub(super) fn with_median(sample: &Sample, measure: &Measure) -> Cell {
    let (Some(mean), Some(median)) = (sample.mean(), sample.median()) else { return dash(NOT_MEASURED) };
    if !(measure.factor * mean).is_finite() {
        return dash("too large for a number");
    }
    let interval = sample.interval().map(|it| [it.low, it.high].map(|end| measure.show(end)));
    let median = (sample.n_objects() > 1).then(|| measure.show(median));
    let note = joined([
        interval.as_ref().map(|[low, high]| format!("{low} to {high}")),
        median.as_ref().map(|median| format!("median {median}")),
    ]);
    let mean = measure.show(mean);
    let values = [("value", mean.clone()), ("n_objects", sample.n_objects().to_string())];
    Cell::with_note(mean, note).with_values(values).with_values(spread(interval, median))
}

/// A mean difference with its interval, its median, p and the number of pairs.
pub(super) fn with_test(
    measure: &Measure,
    mean: f64,
    median: f64,
    interval: Option<Interval>,
    test: SignedRank,
) -> Cell {
    if !(measure.factor * mean).is_finite() {
        return dash("too large for a number");
    }
    let show = |value| measure.show_difference(value);
    let interval = interval.map(|it| [it.low, it.high].map(show));
    let median = (test.n_pairs > 1).then(|| show(median));
    let note = joined([
        interval.as_ref().map(|[low, high]| format!("{low} to {high}")),
        median.as_ref().map(|median| format!("median {median}")),
        Some(format!("{}, n = {}", p_value(test), test.n_pairs)),
    ]);
    let plain = |shown: String| shown.replace('−', "-").replace('+', "");
    let p = p_value(test).replace(['p', '=', ' '], "");
    let values = [("mean", plain(show(mean))), ("p", p), ("n_objects", test.n_pairs.to_string())];
    let spread = spread(interval.map(|ends| ends.map(plain)), median.map(plain));
    Cell::with_note(show(mean), note).with_values(values).with_values(spread)
}

/// Interval and median, by the columns of the data files.
fn spread(
    interval: Option<[String; 2]>,
    median: Option<String>,
) -> impl Iterator<Item = (&'static str, String)> {
    let interval = interval.into_iter().flat_map(|ends| ["low", "high"].into_iter().zip(ends));
    interval.chain(median.map(|median| ("median", median)))
}

/// `p = 0.031`, or `p < 0.001`.
pub(super) fn p_value(test: SignedRank) -> String {
    match test.p_value {
        p if p < 0.001 => "p < 0.001".to_owned(),
        p if p < 0.1 => format!("p = {p:.3}"),
        p => format!("p = {p:.2}"),
    }
}

fn joined<const N: usize>(parts: [Option<String>; N]) -> String {
    parts.into_iter().flatten().collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use nextview_campaign::statistics::measure::{PATH, SKILL};
    use nextview_campaign::statistics::signed_rank;

    fn cell(values: &[f64]) -> (String, String) {
        let cell = with_median(&Sample::new(values.iter().map(|&value| vec![value])), &SKILL);
        (cell.text, cell.note)
    }

    fn pair(text: &str, note: &str) -> (String, String) {
        (text.to_owned(), note.to_owned())
    }

    #[test]
    fn an_outlier_shows_in_the_median() {
        let (text, note) = cell(&[0.8, 0.9, 0.7, -8.25]);
        assert_eq!(text, "-1.46");
        assert!(note.starts_with("-5.99 to ") && note.ends_with(" to 0.85, median 0.75"), "{note}");
        assert_eq!(cell(&[0.5]), pair("0.50", ""));
    }

    #[test]
    fn no_cell_shows_what_is_no_number() {
        assert_eq!(cell(&[]), pair("–", NOT_MEASURED));
        assert_eq!(cell(&[f64::MAX, f64::MAX]), pair("–", "too large for a number"));
        assert_eq!(cell(&[f64::NAN]), pair("–", "too large for a number"));
        let huge = Interval { low: f64::NEG_INFINITY, high: f64::INFINITY };
        let test = signed_rank(&[1.0]).unwrap();
        assert_eq!(with_test(&PATH, 1.0, 1.0, Some(huge), test).note, "– to –, p = 1.00, n = 1");
    }

    #[test]
    fn small_probabilities_are_bounds() {
        let p = |p_value| super::p_value(SignedRank { p_value, n_pairs: 9, n_different: 9 });
        assert_eq!([p(1e-5), p(0.0123), p(0.456)], ["p < 0.001", "p = 0.012", "p = 0.46"]);
    }
}
