//! The parameters in the rows and columns of the paper's tables.

use super::published;
use crate::campaign::planner_section::other_sections;
use nextview_campaign::statistics::StudyVariant;
use nextview_scan::PlannerChoice;
use serde_json::Value;

/// A parameter that distinguishes variants, or a few related ones.
#[derive(Clone, Copy)]
pub(super) struct ParameterAxis {
    pub name: &'static str,
    /// Dotted keys of the configuration.
    pub keys: &'static [&'static str],
    /// The value of a variant; `None` if the variant has no place in the table.
    pub label: fn(&PlannerChoice, &Value) -> Option<String>,
}

pub(super) const METHOD: ParameterAxis =
    ParameterAxis { name: "method", keys: &["planner"], label: |planner, _| Some(method(planner)) };

pub(super) const MULTI: ParameterAxis = ParameterAxis {
    name: "multi-resolution",
    keys: &["multi_resolution"],
    label: |_, config| {
        let is_on = find(config, "multi_resolution.enabled") == Some(&Value::Bool(true));
        let coarsest = find(config, "multi_resolution.coarsest_voxel_size_m").and_then(number);
        Some(match (is_on, coarsest) {
            (false, _) => "single".to_owned(),
            (true, None) => "multi".to_owned(),
            (true, Some(coarsest)) => format!("multi from {coarsest} m"),
        })
    },
};

pub(super) const HISTORY: ParameterAxis = ParameterAxis {
    name: "history",
    keys: &["max_flow.uses_history"],
    label: |_, config| {
        let is_off = find(config, "max_flow.uses_history") == Some(&Value::Bool(false));
        Some(if is_off { "without history" } else { "with history" }.to_owned())
    },
};

pub(super) const GAMMA: ParameterAxis = ParameterAxis {
    name: "γ",
    keys: &["max_flow.gamma"],
    label: |planner, config| {
        let properties = planner.properties();
        let is_read = properties.section == Some("max_flow") && !properties.fixes_gamma;
        find(config, "max_flow.gamma").filter(|_| is_read).and_then(number)
    },
};

pub(super) const Q_THRESH: ParameterAxis = ParameterAxis {
    name: "q_thresh",
    keys: &["multi_resolution.q_thresh"],
    label: |_, config| find(config, "multi_resolution.q_thresh").and_then(number),
};

pub(super) const THETA: ParameterAxis = ParameterAxis {
    name: "θ",
    keys: &["most_surface.theta", "max_flow.theta", "greedy.theta", "batch.theta"],
    label: |planner, config| {
        find(config, &format!("{}.theta", planner.properties().section?)).and_then(number)
    },
};

fn method(planner: &PlannerChoice) -> String {
    published::method(planner).map_or_else(|| planner.to_string(), str::to_owned)
}

/// The variant's parameters, without those that differ between its runs or that its planner does not read.
pub(super) fn configuration(variant: &StudyVariant) -> Value {
    let mut config = serde_json::to_value(&variant.example).unwrap_or_default();
    let of_runs =
        ["object", "unit", "size_m", "seed", "baseline_seed", "view_seed", "noise.seed", "first_view"];
    for key in of_runs.into_iter().chain(other_sections(&variant.planner)) {
        remove(&mut config, key);
    }
    config
}

fn find<'v>(config: &'v Value, key: &str) -> Option<&'v Value> {
    key.split('.').try_fold(config, |value, part| value.get(part))
}

/// Removes a parameter by its dotted key.
pub(super) fn remove(config: &mut Value, key: &str) {
    let Value::Object(fields) = config else { return };
    match key.split_once('.') {
        Some((first, rest)) => fields.get_mut(first).into_iter().for_each(|inner| remove(inner, rest)),
        None => drop(fields.remove(key)),
    }
}

fn number(value: &Value) -> Option<String> {
    value.as_f64().map(|number| number.to_string())
}
