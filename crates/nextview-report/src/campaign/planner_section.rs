use nextview_scan::{Named, PlannerChoice, PlannerName};

/// The sections of the configuration with parameters of other planners, which this planner does not read. A
/// section that several planners share occurs several times.
pub(super) fn other_sections(planner: &PlannerChoice) -> impl Iterator<Item = &'static str> {
    let own = planner.properties().section;
    let sections = PlannerName::ALL.iter().filter_map(|other| other.properties().section);
    sections.filter(move |section| Some(*section) != own)
}
