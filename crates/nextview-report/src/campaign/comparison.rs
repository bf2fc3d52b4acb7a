use super::statistic::p_value;
use nextview_campaign::statistics::{Comparison, MeasureComparison, VariantComparison};

/// Maximum number of runs in a list.
const MAX_NAMED: usize = 10;

/// Formats the comparison of two campaigns; `a` and `b` are the displayed names.
pub fn comparison_text(comparison: &Comparison, a: &str, b: &str) -> String {
    let runs = |n: usize| if n == 1 { "1 run".to_owned() } else { format!("{n} runs") };
    let mut out = format!(
        "A  {a}: {}\nB  {b}: {}\n\n{} in both",
        runs(comparison.n_runs_a),
        runs(comparison.n_runs_b),
        runs(comparison.n_pairs)
    );
    let pairs_are_identical = comparison.pairs_are_identical && comparison.n_pairs > 0;
    out += match (pairs_are_identical, comparison.is_identical()) {
        (_, true) => ", nothing else: identical apart from times and memory\n",
        (true, _) => ", identical apart from times and memory\n",
        _ => "\n",
    };
    for (title, names) in [
        ("only in A", &comparison.only_in_a),
        ("only in B", &comparison.only_in_b),
        ("failed only in A", &comparison.failed_only_in_a),
        ("failed only in B", &comparison.failed_only_in_b),
    ] {
        out += &list(title, names);
    }
    comparison.variants.iter().for_each(|variant| out += &variant_text(variant));
    out
}

fn list(title: &str, names: &[String]) -> String {
    if names.is_empty() {
        return String::new();
    }
    let more = names.len().saturating_sub(MAX_NAMED);
    let named: String = names.iter().take(MAX_NAMED).map(|name| format!("  {name}\n")).collect();
    let more = if more > 0 { format!("  and {more} more\n") } else { String::new() };
    format!("{title}: {}\n{named}{more}", names.len())
}

fn variant_text(variant: &VariantComparison) -> String {
    let names = match variant.variant_a == variant.variant_b {
        true => variant.variant_a.clone(),
        false => format!("{} (A) against {} (B)", variant.variant_a, variant.variant_b),
    };
    let objects = if variant.n_objects == 1 { "object" } else { "objects" };
    let rows: String = variant.measures.iter().map(measure_text).collect();
    let head =
        line("", ["A", "B", "B - A", "median", "95 % interval"].map(str::to_owned), "p, objects, verdict");
    let lists = [("better", &variant.better), ("worse", &variant.worse)].map(|(word, objects)| {
        let named: Vec<String> =
            objects.iter().map(|(name, points)| format!("{name} {}", signed(*points, 1))).collect();
        let title = format!("  {word} in B by more than 0.1 points of voxel coverage");
        if named.is_empty() { format!("{title}: none\n") } else { format!("{title}: {}\n", named.join(", ")) }
    });
    format!("\n{names}, {} {objects}\n{head}{rows}{}", variant.n_objects, lists.concat())
}

fn line(name: &str, [a, b, difference, median, interval]: [String; 5], end: &str) -> String {
    format!("  {name:<27}{a:>9}{b:>9}{difference:>15}{median:>9}   {interval:<20}{end}\n")
}

fn measure_text(comparison: &MeasureComparison) -> String {
    let MeasureComparison { a, b, difference, median_difference, interval, test, .. } = *comparison;
    let decimals = comparison.measure.decimals;
    let show = |value: f64| match comparison.is_ratio {
        true => number(value, |value| format!("x {value:.2}")),
        false => signed(value, decimals + 1),
    };
    let unit = comparison.measure.difference_unit().map_or(String::new(), |unit| format!(" {unit}"));
    let interval = interval.map_or("–".to_owned(), |it| format!("{} … {}", show(it.low), show(it.high)));
    let mean = |value: f64| number(value, |value| format!("{value:.decimals$}"));
    let numbers = [mean(a), mean(b), show(difference) + &unit, show(median_difference), interval];
    line(comparison.name, numbers, &format!("{}, {}, {}", p_value(test), test.n_pairs, verdict(comparison)))
}

/// Whether B differs from A. An interval that includes "no difference" does not prove that there is none.
fn verdict(comparison: &MeasureComparison) -> &'static str {
    match (comparison.b_is_better, comparison.is_more_than_noise, comparison.interval) {
        _ if comparison.test.n_different == 0 => "the same on every object",
        (_, _, None) => "a single run",
        (Some(true), true, _) => "better",
        (Some(false), true, _) => "worse",
        _ => "no difference shown",
    }
}

fn signed(value: f64, decimals: usize) -> String {
    // Plus zero turns a negative zero into zero.
    number(value, |value| format!("{:+.decimals$}", value + 0.0).replace('-', "−"))
}

/// The number as text; a dash if it is too large.
fn number(value: f64, show: impl Fn(f64) -> String) -> String {
    if value.is_finite() { show(value) } else { "–".to_owned() }
}

#[cfg(test)]
mod tests {
    use super::super::synthetic::{campaign, record_mut};
    use super::*;
    use nextview_campaign::statistics::compare;

    /// The lines of two campaigns of six objects, with the runs of B changed by the object's number.
    fn lines(change: impl Fn(usize, &mut nextview_scan::ScanRecord)) -> Vec<String> {
        let a = campaign(&["max-flow"], 6);
        let mut b = a.clone();
        b.runs.iter_mut().enumerate().for_each(|(i, run)| change(i, record_mut(run)));
        comparison_text(&a.stored(|a| b.stored(|b| compare(a, b).unwrap())), "a", "b")
            .lines()
            .map(str::to_owned)
            .collect()
    }

    fn of<'l>(lines: &'l [String], measure: &str) -> &'l str {
        lines.iter().find(|line| line.trim_start().starts_with(measure)).expect("the measure has a line")
    }

    #[test]
    fn a_difference_that_is_not_shown_is_not_called_equal() {
        // Differences of -0.75 and +0.75 points, with a mean of exactly 0.
        let lines = lines(|i, record| {
            let shift = if i % 2 == 0 { 0.0078125 } else { -0.0078125 };
            for coverage in record.steps.iter_mut().filter_map(|step| step.voxel_coverage.as_mut()) {
                *coverage += shift;
            }
        });
        assert!(!lines.concat().contains("equal"), "{lines:#?}");
        let coverage = of(&lines, "voxel coverage, %");
        assert!(coverage.contains(" points ") && coverage.contains('…'), "{coverage}");
        assert!(coverage.contains("p = ") && coverage.ends_with(", 6, no difference shown"), "{coverage}");
        assert!(of(&lines, "skill").ends_with(", 6, the same on every object"));
    }

    #[test]
    fn percentages_differ_by_points_and_times_by_ratios_of_the_means_that_are_shown() {
        let lines = lines(|i, record| {
            for step in record.steps.iter_mut().skip(1) {
                step.voxel_coverage = step.voxel_coverage.map(|coverage| coverage - 0.112);
                // Twice as fast on two objects, a little slower on the others.
                step.plan_time_ms *= if i < 2 { 0.5 } else { 1.05 };
            }
        });
        let coverage = of(&lines, "voxel coverage, %");
        assert!(coverage.contains("−11.20 points   −11.20   −11.20 … −11.20"), "{coverage}");
        assert!(coverage.ends_with("p = 0.031, 6, worse"), "{coverage}");
        let time: Vec<&str> = of(&lines, "planning time").split_whitespace().collect();
        let at = time.iter().position(|word| *word == "x").unwrap();
        let [a, b, ratio] = [at - 2, at - 1, at + 1].map(|i| time[i].parse::<f64>().unwrap());
        assert!((b / a - ratio).abs() < 0.006, "{time:?}");
    }

    #[test]
    fn numbers_that_are_none_are_dashes() {
        let lines = lines(|_, record| record.steps.iter_mut().for_each(|step| step.path_length_m = f64::MAX));
        assert!(!lines.concat().contains("inf") && !lines.concat().contains("NaN"), "{lines:#?}");
        assert!(of(&lines, "path length, m").contains('–'));
    }
}
