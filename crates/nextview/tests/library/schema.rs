//! The JSON Schemas say what is read and written.
#![cfg(feature = "schema")]
#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use glam::DVec3;
use nextview::geometry::Aabb;
use nextview::planner::{BatchConfig, Explanation, GreedyConfig, MaxFlowConfig, MostSurfaceConfig};
use nextview::registration::{RegistrationConfig, Verdict};
use nextview::session::{SessionConfig, StopReason};
use schemars::{JsonSchema, schema_for};
use serde::Serialize;
use std::collections::BTreeSet;

/// Asserts that the schema has a property for every key that is written.
fn check<T: JsonSchema + Serialize>(value: &T) {
    let schema = serde_json::to_value(schema_for!(T)).unwrap();
    let keys: BTreeSet<String> =
        serde_json::to_value(value).unwrap().as_object().unwrap().keys().cloned().collect();
    let properties: BTreeSet<String> = schema["properties"].as_object().unwrap().keys().cloned().collect();
    assert!(keys.is_subset(&properties), "{keys:?} and {properties:?}");
    assert_eq!(schema["additionalProperties"], false);
}

#[test]
fn every_key_has_a_property() {
    check(&SessionConfig::new(0.01, Aabb::cube(DVec3::ZERO, 0.1)));
    check(&MaxFlowConfig::default());
    check(&GreedyConfig::default());
    check(&BatchConfig::default());
    check(&MostSurfaceConfig::default());
    check(&RegistrationConfig::default());
    let session = serde_json::to_value(schema_for!(SessionConfig)).unwrap();
    assert_eq!(session["required"], serde_json::json!(["voxel_size_m", "object_box"]));
}

#[test]
fn records_have_schemas() {
    let reasons = serde_json::to_string(&schema_for!(StopReason)).unwrap();
    assert!(reasons.contains("\"view-limit\"") && reasons.contains("\"cancelled\""), "{reasons}");
    let verdicts = serde_json::to_string(&schema_for!(Verdict)).unwrap();
    assert!(verdicts.contains("\"little-overlap\""), "{verdicts}");
    let explanation = serde_json::to_value(schema_for!(Explanation)).unwrap();
    assert_eq!(explanation["type"], "object");
}
