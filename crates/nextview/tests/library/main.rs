//! The library from outside: maps, gains, planners, sessions, models. One program, so that it is linked once.

mod batch;
mod checked;
#[path = "../common/mod.rs"]
mod common;
mod diagnosis;
mod frontier_tour;
mod gains;
mod half_seen_ball;
mod layers;
mod max_flow_twin;
mod nonsense;
mod planner;
mod receding_horizon;
mod schema;
mod sensors;
mod stop_rules;
