//! The comparison of two campaigns as text.

use super::compare::{Comparison, MeasureComparison, VariantComparison};

/// Most runs that are named one by one.
const MAX_NAMED: usize = 10;

impl Comparison {
    /// For people; A and B are the names to show.
    pub fn to_text(&self, a: &str, b: &str) -> String {
        let runs = |n: usize| if n == 1 { "1 run".to_owned() } else { format!("{n} runs") };
        let mut out = format!(
            "A  {a}: {}\nB  {b}: {}\n\n{} in both",
            runs(self.n_runs_a),
            runs(self.n_runs_b),
            runs(self.n_pairs)
        );
        out += match (self.pairs_are_identical && self.n_pairs > 0, self.is_identical()) {
            (_, true) => ", nothing else: identical apart from times and memory\n",
            (true, _) => ", identical apart from times and memory\n",
            _ => "\n",
        };
        for (what, names) in [
            ("only in A", &self.only_in_a),
            ("only in B", &self.only_in_b),
            ("failed only in A", &self.failed_only_in_a),
            ("failed only in B", &self.failed_only_in_b),
        ] {
            out += &list(what, names);
        }
        self.variants.iter().for_each(|variant| out += &variant.to_text());
        out
    }
}

fn list(what: &str, names: &[String]) -> String {
    if names.is_empty() {
        return String::new();
    }
    let more = names.len().saturating_sub(MAX_NAMED);
    let named: String = names.iter().take(MAX_NAMED).map(|name| format!("  {name}\n")).collect();
    let more = if more > 0 { format!("  and {more} more\n") } else { String::new() };
    format!("{what}: {}\n{named}{more}", names.len())
}

impl VariantComparison {
    fn to_text(&self) -> String {
        let names = match self.variant_a == self.variant_b {
            true => self.variant_a.clone(),
            false => format!("{} (A) against {} (B)", self.variant_a, self.variant_b),
        };
        let objects = if self.n_objects == 1 { "object" } else { "objects" };
        let rows: String = self.measures.iter().map(MeasureComparison::to_text).collect();
        let head = format!("{:<26}{:>10}{:>10}{:>11}   {}\n", "", "A", "B", "B - A", "95 % interval");
        let lists = [("better", &self.better), ("worse", &self.worse)].map(|(word, objects)| {
            let named: Vec<String> =
                objects.iter().map(|(name, points)| format!("{name} {}", signed(*points, 1))).collect();
            let what = format!("  {word} in B by more than 0.1 point of voxel coverage");
            if named.is_empty() {
                format!("{what}: none\n")
            } else {
                format!("{what}: {}\n", named.join(", "))
            }
        });
        format!("\n{names}, {} {objects}\n{head}{rows}{}", self.n_objects, lists.concat())
    }
}

impl MeasureComparison {
    fn to_text(&self) -> String {
        let decimals = self.measure.decimals;
        let show = |value: f64| match self.is_ratio {
            true => format!("x {value:.2}"),
            false => signed(value, decimals + 1),
        };
        let interval = self
            .interval
            .map_or("-".to_owned(), |interval| format!("{} to {}", show(interval.low), show(interval.high)));
        let verdict = match (self.b_is_better, self.is_more_than_noise) {
            (None, _) => "equal",
            (Some(true), true) => "better",
            (Some(false), true) => "worse",
            (_, false) => "within noise",
        };
        format!(
            "  {:<24}{:>10}{:>10}{:>11}   {:<22}{verdict}\n",
            self.name,
            format!("{:.decimals$}", self.a),
            format!("{:.decimals$}", self.b),
            show(self.difference),
            interval
        )
    }
}

fn signed(value: f64, decimals: usize) -> String {
    // Plus zero turns a negative zero into zero.
    format!("{:+.decimals$}", value + 0.0)
}
