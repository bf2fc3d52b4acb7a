//! The timed stages, each with its cases.

mod files;
mod insertion;
mod model;
mod planning;
mod rendering;
mod scan;
mod timed_stage;

pub use timed_stage::{Stage, TimedWork};

/// Returns all stages, in the order of the pipeline.
pub fn stages() -> Vec<Stage> {
    let groups = [
        rendering::stages(),
        insertion::stages(),
        planning::stages(),
        model::stages(),
        files::stages(),
        scan::stages(),
    ];
    groups.into_iter().flatten().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_fields_of_a_line() {
        let stages = stages();
        let is_field = |text: &str| !text.contains(',') && !text.contains('|');
        assert!(stages.iter().all(|stage| is_field(stage.name) && is_field(&stage.case)));
        let mut names: Vec<String> = stages.iter().map(Stage::to_string).collect();
        names.sort();
        names.dedup();
        assert_eq!(names.len(), stages.len());
    }
}
