use nextview_campaign::statistics::{Comparison, MeasureComparison, VariantComparison};

/// Maximum number of runs in a list.
const MAX_NAMED: usize = 10;

/// The comparison of two campaigns as text; `a` and `b` are the names to show.
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
    let head = format!("{:<28}{:>10}{:>10}{:>11}   {}\n", "", "A", "B", "B - A", "95 % interval");
    let lists = [("better", &variant.better), ("worse", &variant.worse)].map(|(word, objects)| {
        let named: Vec<String> =
            objects.iter().map(|(name, points)| format!("{name} {}", signed(*points, 1))).collect();
        let title = format!("  {word} in B by more than 0.1 point of voxel coverage");
        if named.is_empty() { format!("{title}: none\n") } else { format!("{title}: {}\n", named.join(", ")) }
    });
    format!("\n{names}, {} {objects}\n{head}{rows}{}", variant.n_objects, lists.concat())
}

fn measure_text(comparison: &MeasureComparison) -> String {
    let decimals = comparison.measure.decimals;
    let show = |value: f64| match comparison.is_ratio {
        true => format!("x {value:.2}"),
        false => signed(value, decimals + 1),
    };
    let interval = comparison
        .interval
        .map_or("-".to_owned(), |interval| format!("{} to {}", show(interval.low), show(interval.high)));
    let verdict = match (comparison.b_is_better, comparison.is_more_than_noise) {
        (None, _) => "equal",
        (Some(true), true) => "better",
        (Some(false), true) => "worse",
        (_, false) => "within noise",
    };
    format!(
        "  {:<26}{:>10}{:>10}{:>11}   {:<22}{verdict}\n",
        comparison.name,
        format!("{:.decimals$}", comparison.a),
        format!("{:.decimals$}", comparison.b),
        show(comparison.difference),
        interval
    )
}

fn signed(value: f64, decimals: usize) -> String {
    // Plus zero turns a negative zero into zero.
    format!("{:+.decimals$}", value + 0.0)
}
