//! From gains to a decision.
//!
//! A [`ViewPlanner`] is a pure function from a [`Situation`] to a [`Plan`]. [`MaxFlow`] is the paper's; with
//! `gamma = 0` it is the greedy local planner. [`Greedy`] takes any of the literature's gains. [`Batch`] chooses several views
//! at once and the order to visit them in. [`MinOverlap`] leaves any of them only the views
//! that overlap with what is known. [`RandomViews`] is the baseline that every planner must beat, [`InOrder`] what a
//! recording did.

mod batch;
mod field;
mod flow_gain;
mod greedy;
mod in_order;
mod max_flow;
mod min_overlap;
mod most_surface;
mod random_views;
mod second_view;
mod survey;
mod trade_off;
mod utility;
mod view_planner;
mod worth;

pub use batch::{Batch, BatchConfig, BatchPlan, BatchView};
pub use flow_gain::flow_gain;
pub use greedy::{Greedy, GreedyConfig};
pub use in_order::InOrder;
pub use max_flow::{MaxFlow, MaxFlowConfig};
pub use min_overlap::MinOverlap;
pub use most_surface::{MostSurface, MostSurfaceConfig};
pub use random_views::RandomViews;
pub use view_planner::{Choice, FlowSummary, Itinerary, Leg, Outlook, Plan, Situation, ViewPlanner};
