use super::section::Section;
use super::{FaultList, FirstViews};
use nextview_scan::Fault;
use serde::Serialize;
use toml::{Table, Value};

/// A planner with its parameters, or several with a sweep.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct VariantSpec {
    /// Name in the results; `{path}` in it stands for that value of the configuration. By default made of the
    /// planner's name and the swept values.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub label: Option<String>,
    /// Seeds in place of the specification's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seeds: Option<Vec<u64>>,
    /// Sets of candidates in place of the specification's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub view_seeds: Option<Vec<u64>>,
    /// First views in place of the specification's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub first_views: Option<FirstViews>,
    /// Keys of [`ScanConfig`](nextview_scan::ScanConfig), which override the specification's.
    #[serde(skip_serializing_if = "Table::is_empty")]
    pub scan: Table,
    /// Lists of values for keys of [`ScanConfig`](nextview_scan::ScanConfig), which override both.
    #[serde(skip_serializing_if = "Table::is_empty")]
    pub sweep: Table,
}

impl VariantSpec {
    /// Reads an entry of the list of variants.
    pub(super) fn read(entry: Value, index: usize, faults: &mut FaultList) -> Option<Self> {
        let name = format!("variant {}", index + 1);
        let Value::Table(table) = entry else {
            let fault = Fault::data(format!("{name} is of type {}, expected a table", entry.type_str()));
            faults.add(&format!("variant.{index}"), fault);
            return None;
        };
        let mut section = Section::entry("variant", index, name, table, faults);
        let (label, seeds) = (section.take("label"), section.take("seeds"));
        let (view_seeds, first_views) = (section.take("view_seeds"), section.take("first_views"));
        let (scan, sweep) = (section.take("scan"), section.take("sweep"));
        section.end();
        let (scan, sweep) = (scan.unwrap_or_default(), sweep.unwrap_or_default());
        Some(Self { label, seeds, view_seeds, first_views, scan, sweep })
    }
}
