//! From gains to a decision.
//!
//! A [`ViewPlanner`] makes a [`Plan`] of a [`Situation`]. [`MaxFlow`] is the paper's planner; with `gamma =
//! 0` it is the greedy local planner. [`Greedy`] takes any gain from the literature, [`GreedyByView`] one
//! that evaluates all rays of a view at once. [`Batch`] chooses several views at once and their order. Four
//! planners from the literature are more than a gain: [`FrontierTour`] follows a tour past the frontier,
//! [`PbNbv`] projects ellipsoids, [`See`] looks at the edges of dense points, and [`RecedingHorizon`] takes
//! the best branch of a random tree. [`MinOverlap`] restricts any of them to views that overlap with known
//! surface. [`EvenViews`] goes all around the object, [`RandomViews`] is the baseline that every planner must
//! beat, and [`InOrder`] repeats the order of a recording. A [`Fallback`] answers where a session's planner
//! has nothing to say.

mod batch;
mod even_views;
mod explanation;
mod fallback;
mod frontier_tour;
mod greedy;
mod greedy_by_view;
mod in_order;
mod max_flow;
mod min_overlap;
mod most_surface;
mod pb_nbv;
mod random_views;
mod ray_config;
mod receding_horizon;
mod see;
mod utility;
mod view_gain;
mod view_planner;

pub use batch::{Batch, BatchConfig, BatchPlan, BatchView};
pub use even_views::EvenViews;
pub use explanation::Explanation;
pub use fallback::{Fallback, PlanLegs};
pub use frontier_tour::FrontierTour;
pub use greedy::{Greedy, GreedyConfig};
pub use greedy_by_view::GreedyByView;
pub use in_order::InOrder;
pub use max_flow::{MaxFlow, MaxFlowConfig, flow_gain};
pub use min_overlap::MinOverlap;
pub use most_surface::{MostSurface, MostSurfaceConfig};
pub use pb_nbv::PbNbv;
pub use random_views::RandomViews;
pub use ray_config::RayConfig;
pub use receding_horizon::RecedingHorizon;
pub use see::See;
pub use view_gain::ViewGain;
pub use view_planner::{Choice, Itinerary, Leg, Outlook, Plan, Situation, ViewPlanner};
