use super::{Named, PlannerName};

/// What a planner needs, offers and reads, as stated in its row of the table of planners.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PlannerProperties {
    /// The section of the configuration with the planner's parameters; `None` if it has no parameters.
    pub section: Option<&'static str>,
    /// Whether its section's `gamma` is always 0 for it.
    pub fixes_gamma: bool,
    /// Whether it requires the depth images behind the map.
    pub needs_frames: bool,
    /// Whether it requires the true object.
    pub needs_truth: bool,
    /// Whether it requires the CAD model of the part.
    pub needs_reference: bool,
    /// Whether a network chooses the view: even before any surface was seen, and in a hundred times the time
    /// of other planners.
    pub is_network: bool,
    /// Whether its views are the random baseline.
    pub is_random: bool,
    /// Whether it takes the views in the order of their numbers, so that each is near the one before.
    pub is_in_order: bool,
    /// Whether it estimates completeness and expected gain, which some stop rules require.
    pub estimates_completeness: bool,
    /// Whether it takes second looks, which a goal requires.
    pub takes_second_looks: bool,
    /// Whether it can weigh a view's gain by the seconds that the view takes.
    pub counts_seconds: bool,
}

impl PlannerProperties {
    /// Whether the planner needs only a map: neither frames nor the true object.
    pub fn plans_from_map(&self) -> bool {
        !self.needs_frames && !self.needs_truth
    }
}

/// The remedy for a planner that lacks a property: the names of those that have it.
pub(super) fn remedy(has: impl Fn(&PlannerProperties) -> bool) -> String {
    let names = PlannerName::ALL.iter().filter(|planner| has(&planner.properties()));
    let names: Vec<_> = names.map(|planner| planner.name()).collect();
    format!("`planner` = {} does", names.join(" or "))
}
