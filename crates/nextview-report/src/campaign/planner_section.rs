use nextview_scan::{PlannerChoice, PlannerName};

/// Configuration sections with planner parameters.
pub(super) const PLANNER_SECTIONS: [&str; 5] = ["most_surface", "max_flow", "greedy", "batch", "nbv_net"];

/// The section that this planner reads; `None` if it has no parameters.
pub(super) fn section_of(planner: &PlannerChoice) -> Option<&'static str> {
    use PlannerName as Name;
    match planner.built_in() {
        Some(Name::MostSurface) => Some("most_surface"),
        Some(Name::MaxFlow | Name::Local) => Some("max_flow"),
        Some(Name::Batch) => Some("batch"),
        Some(Name::NbvNet) => Some("nbv_net"),
        Some(Name::PbNbv | Name::See | Name::NbvRegression | Name::PcNbv) => None,
        Some(Name::EvenViews | Name::Inspection) => None,
        Some(Name::InOrder | Name::Random | Name::Clairvoyant) => None,
        // Planners named after a gain, and planners in Python.
        _ => Some("greedy"),
    }
}
