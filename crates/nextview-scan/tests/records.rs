//! The JSON Schemas in the repository match the types.

#![cfg(feature = "schema")]
#![allow(clippy::unwrap_used, reason = "helpers of a test")]

#[test]
fn schemas_are_those_of_the_types() {
    use nextview_scan::{ScanConfig, ScanRecord, StepRecord, ViewRecord};
    let schemas = [
        ("step_record", schemars::schema_for!(StepRecord)),
        ("scan_record", schemars::schema_for!(ScanRecord)),
        ("view_record", schemars::schema_for!(ViewRecord)),
        ("scan_config", schemars::schema_for!(ScanConfig)),
    ];
    for (name, schema) in schemas {
        let path = format!("{}/schema/{name}.json", env!("CARGO_MANIFEST_DIR"));
        let text = serde_json::to_string_pretty(&schema).unwrap() + "\n";
        if std::env::var_os("NEXTVIEW_WRITE_SCHEMAS").is_some() {
            std::fs::write(&path, &text).unwrap();
        }
        let kept = std::fs::read_to_string(&path).unwrap_or_default();
        assert!(kept == text, "{path} differs from the types: write it anew with NEXTVIEW_WRITE_SCHEMAS=1");
    }
}
