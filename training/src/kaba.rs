//! Trains the policy of the planner kaba by Watkins's Q-learning on scans of random objects, and compares it
//! with every fixed boundary weight on other objects.

use fixedbitset::FixedBitSet;
use glam::DVec2;
use nextview::Error;
use nextview::geometry::Lattice;
use nextview::geometry::random::Random;
use nextview::planner::{Plan, Situation, ViewPlanner};
use nextview::sensor::Intrinsics;
use nextview::session::{Decision, Session, SessionConfig, StopConfig};
use nextview::view::{ViewSpace, generate};
use nextview_learned::kaba::{BOUNDARY_WEIGHTS, Kaba, N_FEATURES, Policy, Surveyor};
use nextview_sim::random_object::{random_object, seeds};
use nextview_sim::scene::Scene;
use nextview_sim::truth::ObjectVoxels;
use rayon::prelude::*;
use std::sync::{Arc, Mutex};

const N_ACTIONS: usize = BOUNDARY_WEIGHTS.len();

/// Metres: 26 voxels along the box of an object of 0.2 m.
const VOXEL_SIZE: f64 = 0.01;

const N_CANDIDATES: usize = 100;

/// An episode ends after this number of views, or at this share of the surface that all candidates together
/// see.
const MAX_VIEWS: usize = 20;
const ENOUGH: f64 = 0.95;

const RAY_SPACING: f64 = 2.0;

/// Learning step, decay of the traces, and exploration probability in the first and the last episode.
const STEP: f64 = 0.01;
const TRACE_DECAY: f64 = 0.8;
const EXPLORES: [f64; 2] = [0.2, 0.01];

/// Separates these draws from others with the same seed.
const STREAM: u64 = 61;

/// Number of held-out objects on which policies are compared.
const N_COMPARED: u64 = 60;

/// A linear action-value function that learns step by step by Watkins's Q(lambda), without discount.
struct Learning {
    weights: [[f64; N_FEATURES]; N_ACTIONS],
    trace: [[f64; N_FEATURES]; N_ACTIONS],
}

impl Learning {
    fn new() -> Self {
        Self { weights: [[0.0; N_FEATURES]; N_ACTIONS], trace: [[0.0; N_FEATURES]; N_ACTIONS] }
    }

    fn policy(&self) -> Policy {
        Policy::new(&self.weights)
    }

    /// Later rewards do not depend on earlier actions: an episode begins, or an action explores.
    fn cut_trace(&mut self) {
        self.trace = [[0.0; N_FEATURES]; N_ACTIONS];
    }

    /// Learns from an action, its reward, and the largest value in the state after it, 0 at the end.
    fn step(&mut self, (features, action): &AgentStep, reward: f64, next: f64) {
        let error = reward + next - self.policy().values(features)[*action];
        self.trace.iter_mut().flatten().for_each(|trace| *trace *= TRACE_DECAY);
        self.trace[*action].iter_mut().zip(features).for_each(|(trace, feature)| *trace += feature);
        for (weight, trace) in self.weights.iter_mut().flatten().zip(self.trace.iter().flatten()) {
            *weight += STEP * error * trace;
        }
    }
}

/// The features of a state, and the action taken in it.
type AgentStep = ([f64; N_FEATURES], usize);

/// An agent that learns while acting.
struct Agent {
    learning: Learning,
    random: Random,
    explores: f64,
    last: Option<AgentStep>,
}

impl Agent {
    fn new(seed: u64) -> Self {
        Self { learning: Learning::new(), random: Random::new(seed, STREAM), explores: 0.0, last: None }
    }

    fn begin(&mut self, explores: f64) {
        self.learning.cut_trace();
        (self.explores, self.last) = (explores, None);
    }

    fn act(&mut self, features: &[f64; N_FEATURES]) -> usize {
        let policy = self.learning.policy();
        let best = policy.choice(features);
        if let Some(last) = &self.last {
            self.learning.step(last, -1.0, policy.values(features)[best]);
        }
        let explores = self.random.unit() < self.explores;
        let action = if explores { self.random.index(N_ACTIONS) } else { best };
        if action != best {
            self.learning.cut_trace();
        }
        self.last = Some((*features, action));
        action
    }

    fn end(&mut self) {
        if let Some(last) = self.last.take() {
            self.learning.step(&last, -1.0, 0.0);
        }
    }
}

/// A planner that follows an agent's actions.
struct AgentPlanner {
    agent: Arc<Mutex<Agent>>,
    surveyor: Surveyor,
}

impl ViewPlanner for AgentPlanner {
    fn plan(&mut self, situation: &Situation<'_>) -> Result<Plan, Error> {
        let survey = self.surveyor.survey(situation)?;
        let choice = survey.and_then(|survey| {
            let action = self.agent.lock().expect("no thread panicked").act(survey.features());
            survey.choice(BOUNDARY_WEIGHTS[action])
        });
        Ok(Plan { choice, ..Plan::default() })
    }
}

/// Learns the policy from scans of `n_episodes` random objects, one after the other.
pub fn learn(n_episodes: u64) -> Policy {
    let agent = Arc::new(Mutex::new(Agent::new(0)));
    for episode in 0..n_episodes {
        let share = episode as f64 / n_episodes.max(2).saturating_sub(1) as f64;
        agent.lock().expect("no thread panicked").begin(EXPLORES[0] + share * (EXPLORES[1] - EXPLORES[0]));
        let surveyor = Surveyor::new(RAY_SPACING).expect("the spacing is in range");
        let trial = Trial::new(seeds::KABA.start + episode);
        trial.n_views(Box::new(AgentPlanner { agent: agent.clone(), surveyor }));
        agent.lock().expect("no thread panicked").end();
    }
    agent.lock().expect("no thread panicked").learning.policy()
}

/// Prints the mean number of views that this policy and every fixed boundary weight need over held-out
/// objects.
pub fn compare(policy: &Policy) {
    let first = seeds::KABA.start.midpoint(seeds::KABA.end);
    let n_views = |seed| {
        let trial = Trial::new(seed);
        let learned = Kaba::with_policy(RAY_SPACING, policy.clone());
        let fixed = BOUNDARY_WEIGHTS.map(|weight| Kaba::with_boundary_weight(RAY_SPACING, weight));
        let all = [learned].into_iter().chain(fixed);
        all.map(|planner| trial.n_views(Box::new(planner.expect("the parameters are in range")))).collect()
    };
    let found: Vec<Vec<usize>> = (first..first + N_COMPARED).into_par_iter().map(n_views).collect();
    println!("views to {:.0} % of the reachable surface, mean of {N_COMPARED} objects", 100.0 * ENOUGH);
    let names = ["learned".to_owned()].into_iter().chain(BOUNDARY_WEIGHTS.map(|weight| weight.to_string()));
    for (place, name) in names.enumerate() {
        let total: usize = found.iter().map(|views| views[place]).sum();
        println!("{name:>7} {:.2}", total as f64 / N_COMPARED as f64);
    }
}

/// A random object in front of a camera that can go anywhere around it.
struct Trial {
    seed: u64,
    scene: Scene,
    views: ViewSpace,
    object: ObjectVoxels,
    /// Number of object voxels at which an episode ends.
    enough: f64,
}

impl Trial {
    fn new(seed: u64) -> Self {
        let scene = Scene::new(random_object(seed), camera()).expect("random objects are small");
        let views = generate::shell(scene.center(), scene.size(), N_CANDIDATES, seed).expect("a shell");
        let lattice = Lattice::new(VOXEL_SIZE).expect("a length");
        let block = lattice.block_inside(&scene.planning_box(VOXEL_SIZE)).expect("larger than a voxel");
        let object = ObjectVoxels::new(scene.camera().mesh(), lattice, block);
        let mut reachable = FixedBitSet::with_capacity(object.len());
        for pose in views.poses() {
            reachable
                .union_with(&object.seen_from(scene.camera(), pose).expect("candidates are in the room"));
        }
        let enough = ENOUGH * reachable.count_ones(..) as f64;
        Self { seed, scene, views, object, enough }
    }

    /// The number of views that a planner needs to see enough: at most [`MAX_VIEWS`], which also counts if it
    /// gives up.
    fn n_views(&self, planner: Box<dyn ViewPlanner>) -> usize {
        let camera = self.scene.camera();
        let config = SessionConfig {
            max_views: MAX_VIEWS,
            first_view: Random::new(self.seed, STREAM).index(self.views.len()),
            stop: StopConfig { progress: 0.0, ..StopConfig::default() },
            ..SessionConfig::new(VOXEL_SIZE, self.scene.planning_box(VOXEL_SIZE))
        };
        let session = Session::new(config, *camera.intrinsics(), self.views.clone(), planner);
        let mut session = session.expect("all is in range");
        let mut seen = FixedBitSet::with_capacity(self.object.len());
        for n in 1.. {
            let Decision::Move(next) = session.decide().expect("nobody cancels") else { break };
            let frame = camera.capture(&next.world_from_camera).expect("candidates are in the room");
            session.observe(&frame).expect("nobody cancels");
            seen.union_with(&self.object.seen_in(&frame));
            if seen.count_ones(..) as f64 >= self.enough {
                return n;
            }
        }
        MAX_VIEWS
    }
}

/// The D435i's field of view with a quarter of its pixels: enough for voxels of 1 cm.
fn camera() -> Intrinsics {
    Intrinsics::pinhole(320, 240, DVec2::splat(305.0), DVec2::new(159.5, 119.5)).expect("a camera")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Four states in a row, two actions: move on or stay. The value of moving on is the negative number of
    /// states left, that of staying one less.
    #[test]
    fn learns_the_values_of_a_chain() {
        let state = |place: usize| std::array::from_fn(|feature| f64::from(u8::from(feature == place)));
        let mut agent = Agent::new(3);
        for _ in 0..4000 {
            agent.begin(0.3);
            let mut place = 0;
            while place < 4 {
                place += usize::from(agent.act(&state(place)) == 0);
            }
            agent.end();
        }
        for place in 0..4 {
            let values = agent.learning.policy().values(&state(place));
            let left = place as f64 - 4.0;
            assert!((values[0] - left).abs() < 0.05, "{place}: {values:?}");
            assert!(values[1..].iter().all(|value| (value - left + 1.0).abs() < 0.4), "{place}: {values:?}");
        }
    }

    #[test]
    fn the_same_episodes_give_the_same_policy() {
        assert_eq!(learn(2), learn(2));
        assert_ne!(learn(2), learn(1));
    }
}
