//! Evaluates variants of the planner most-surface that its settings do not offer: other probabilities, other
//! counts, look-ahead.
//!
//!     cargo run --release -p nextview-evidence --bin questions -- MESH ...
//!
//! Each variant takes ten views of each mesh (longest side 0.2 m, 5 mm voxels, 1000 candidates all around, no
//! noise) and gets a line with its mean skill and its lowest. The first variant is the plain one, without
//! most-surface's rule for the second view and its shortlists, so only one thing changes at a time.

use glam::IVec3;
use nextview::Cancelled;
use nextview::geometry::Pose;
use nextview::map::{LogOdds, Occupancy, Snapshot};
use nextview::planner::{Choice, Plan, Situation, ViewPlanner};
use nextview::prior::{SurfaceEstimate, SurfacePrior, ViewingClass};
use nextview::visibility::{FreeSpace, RayCaster, RayEnd, Sight};
use nextview_benchmarks::Outcome;
use nextview_evidence::known_object::KnownObject;
use rayon::prelude::*;
use std::path::Path;

const RAY_SPACING: f64 = 2.0;

/// Visibility below which a ray ends.
const FADED: f32 = 0.03;

/// Number of views with the largest gain for which a partner is sought.
const N_FIRST: usize = 30;

/// Rounds of mean-field updates: a belief reaches one voxel farther per round.
const N_ROUNDS: usize = 30;

#[derive(Clone, Copy)]
struct QuestionVariant {
    name: &'static str,
    belief: Belief,
    counts: Counts,
    looks_ahead: bool,
}

/// Beliefs about unknown voxels.
#[derive(Clone, Copy)]
enum Belief {
    /// The library's prior.
    Learned,
    /// The library's prior, where a voxel becomes likelier by this coupling in log-odds if its neighbours in
    /// the Markov random field are likelier to stop rays than on their own.
    LearnedField(f32),
    /// A Markov random field without learning: the log-odds that a voxel is solid are this coupling times the
    /// excess of solid voxels among its six neighbours.
    Field(f32),
}

#[derive(Clone, Copy)]
enum Counts {
    OncePerView,
    OncePerRay,
}

const PLAIN: QuestionVariant = QuestionVariant {
    name: "plain",
    belief: Belief::Learned,
    counts: Counts::OncePerView,
    looks_ahead: false,
};

const VARIANTS: [QuestionVariant; 8] = [
    PLAIN,
    QuestionVariant { name: "counts once per ray", counts: Counts::OncePerRay, ..PLAIN },
    QuestionVariant { name: "best pair of views", looks_ahead: true, ..PLAIN },
    QuestionVariant { name: "learned, field 0.5", belief: Belief::LearnedField(0.5), ..PLAIN },
    QuestionVariant { name: "learned, field 2", belief: Belief::LearnedField(2.0), ..PLAIN },
    QuestionVariant { name: "field alone, 0.2", belief: Belief::Field(0.2), ..PLAIN },
    QuestionVariant { name: "field alone, 0.4", belief: Belief::Field(0.4), ..PLAIN },
    QuestionVariant { name: "field alone, 0.8", belief: Belief::Field(0.8), ..PLAIN },
];

fn main() -> Outcome<()> {
    let mut skills = vec![Vec::new(); VARIANTS.len()];
    for path in std::env::args().skip(1) {
        let object = KnownObject::load(Path::new(&path))?;
        for (variant, skills) in VARIANTS.into_iter().zip(&mut skills) {
            let planner = Box::new(VariantPlanner { variant, prior: SurfacePrior::default() });
            skills.extend(object.skill(planner, 0)?);
        }
        eprintln!("{path}: {:.2?}", skills.iter().filter_map(|skills| skills.last()).collect::<Vec<_>>());
    }
    for (variant, skills) in VARIANTS.iter().zip(&skills) {
        let mean = skills.iter().sum::<f64>() / skills.len() as f64;
        let lowest = skills.iter().copied().fold(f64::INFINITY, f64::min);
        println!("{:<20} mean {mean:5.2}, lowest {lowest:5.2}, {} objects", variant.name, skills.len());
    }
    Ok(())
}

struct VariantPlanner {
    variant: QuestionVariant,
    prior: SurfacePrior,
}

impl ViewPlanner for VariantPlanner {
    fn plan(&mut self, situation: &Situation<'_>) -> Result<Plan, nextview::Error> {
        let scene = Beliefs::new(self.variant.belief, &self.prior, situation)?;
        let sight = Sight { free_space: FreeSpace::Fades, fade_limit: FADED };
        let caster = RayCaster::new(&scene.passes, situation.intrinsics(), RAY_SPACING, sight);
        let caster = caster.expect("the spacing is positive");
        let open = situation.open_views();
        let evidence: Vec<Evidence> = open
            .par_iter()
            .map(|&view| {
                situation.cancel().check()?;
                Ok(scene.evidence(&caster, &situation.views().pose(view), self.variant.counts))
            })
            .collect::<Result<_, Cancelled>>()?;
        let mut values: Vec<f64> = evidence.iter().map(|one| one.gain).collect();
        if self.variant.looks_ahead {
            add_partners(&mut values, &evidence, scene.estimate.len());
        }
        let best = (0..open.len()).max_by(|&a, &b| values[a].total_cmp(&values[b]).then(b.cmp(&a)));
        let best = best.filter(|&best| evidence[best].gain > 0.0);
        let choice = best.map(|best| Choice::new(open[best], values[best]));
        Ok(Plan { choice, ..Plan::default() })
    }
}

/// Adds the additional gain of the best partner to the views with the largest gain; all others have no value.
fn add_partners(values: &mut [f64], evidence: &[Evidence], n_items: usize) {
    let mut order: Vec<usize> = (0..evidence.len()).collect();
    order.sort_by(|&a, &b| evidence[b].gain.total_cmp(&evidence[a].gain).then(a.cmp(&b)));
    order.truncate(N_FIRST);
    values.fill(0.0);
    for first in order {
        let mut shown = vec![0.0; n_items];
        evidence[first].shows.iter().for_each(|&(item, p)| shown[item as usize] = p);
        let besides = |other: &Evidence| -> f64 {
            other.shows.iter().map(|&(item, p)| (p - shown[item as usize]).max(0.0) as f64).sum()
        };
        values[first] = evidence[first].gain + evidence.par_iter().map(besides).reduce(|| 0.0, f64::max);
    }
}

/// The beliefs in a situation.
struct Beliefs {
    estimate: SurfaceEstimate,
    belief: Belief,
    /// By voxel of the estimate, the probability that a ray ends there.
    stops: Vec<f32>,
    /// The beliefs as probabilities of a map, for the ray caster.
    passes: Snapshot,
    /// By voxel of the snapshot.
    item_of: Vec<Option<u32>>,
}

/// The surface that a view shows.
struct Evidence {
    gain: f64,
    /// Voxels of the estimate with their probability of being shown.
    shows: Vec<(u32, f32)>,
}

impl Beliefs {
    fn new(belief: Belief, prior: &SurfacePrior, situation: &Situation<'_>) -> Result<Self, Cancelled> {
        let snapshot = situation.snapshot();
        let estimate = prior.estimate(snapshot, situation.cancel())?;
        let mut item_of = vec![None; snapshot.occupancy().len()];
        estimate.voxels().iter().enumerate().for_each(|(i, &voxel)| item_of[voxel as usize] = Some(i as u32));
        let learned: Vec<f32> = (0..estimate.len()).map(|i| estimate.stops(i)).collect();
        let stops = match belief {
            Belief::Learned => learned,
            Belief::LearnedField(coupling) => mean_field(snapshot, &estimate, &item_of, &learned, coupling),
            Belief::Field(coupling) => {
                mean_field(snapshot, &estimate, &item_of, &vec![0.5; learned.len()], 2.0 * coupling)
            }
        };
        let block = snapshot.block();
        let passes = Snapshot::from_fn(snapshot.lattice(), block, |key| {
            let voxel = block.index(key)?;
            let p = match (item_of[voxel], snapshot.occupancy()[voxel]) {
                (Some(item), _) => stops[item as usize].clamp(1e-3, 0.999),
                (None, Occupancy::Occupied) => 0.999,
                (None, _) => 1e-4,
            };
            Some(LogOdds(logit(p)))
        });
        Ok(Self { estimate, belief, stops, passes, item_of })
    }

    fn evidence(&self, caster: &RayCaster<'_>, pose: &Pose, counts: Counts) -> Evidence {
        let (mut best, mut seen, mut gain) = (vec![0.0_f32; self.estimate.len()], Vec::new(), 0.0);
        caster.cast(pose, |ray| {
            let last = if let RayEnd::Occupied(last) = ray.end { Some(last) } else { None };
            for crossing in ray.crossings.iter().copied().chain(last) {
                let Some(item) = self.item_of[crossing.voxel as usize] else { continue };
                let best = &mut best[item as usize];
                if *best == 0.0 {
                    seen.push(item);
                }
                *best = best.max(crossing.visibility);
                if let Counts::OncePerRay = counts {
                    gain += self.shows(item, crossing.visibility, pose) as f64;
                }
            }
        });
        let shows: Vec<(u32, f32)> =
            seen.into_iter().map(|item| (item, self.shows(item, best[item as usize], pose))).collect();
        if let Counts::OncePerView = counts {
            gain = shows.iter().map(|(_, p)| *p as f64).sum();
        }
        Evidence { gain, shows }
    }

    fn shows(&self, item: u32, visibility: f32, pose: &Pose) -> f32 {
        let i = item as usize;
        if let Belief::Field(_) = self.belief {
            return visibility * self.stops[i];
        }
        let (lattice, block) = (self.passes.lattice(), self.passes.block());
        let center = lattice.center(block.key(self.estimate.voxels()[i] as usize));
        let toward = (pose.translation() - center).as_vec3().normalize();
        self.estimate.shows(i, ViewingClass::new(visibility, toward.dot(self.estimate.normal(i))))
    }
}

/// The mean-field solution of a Markov random field over unknown voxels with six neighbours each: the
/// log-odds of a voxel are its own, plus the coupling times the excess of its neighbours' belief in solidity
/// over their prior. Occupied neighbours are certainly solid, free ones certainly not; their prior is that of
/// this voxel.
fn mean_field(
    snapshot: &Snapshot,
    estimate: &SurfaceEstimate,
    item_of: &[Option<u32>],
    alone: &[f32],
    coupling: f32,
) -> Vec<f32> {
    let block = snapshot.block();
    let mut belief = alone.to_vec();
    for _ in 0..N_ROUNDS {
        let update = |(i, &voxel): (usize, &u32)| {
            let key = block.key(voxel as usize);
            let excess = |step: IVec3| match block.index(key + step) {
                None => 0.0,
                Some(other) => match (item_of[other], snapshot.occupancy()[other]) {
                    (Some(other), _) => belief[other as usize] - alone[other as usize],
                    (None, Occupancy::Occupied) => 1.0 - alone[i],
                    (None, _) => -alone[i],
                },
            };
            let steps = [IVec3::X, IVec3::Y, IVec3::Z];
            let sum: f32 = steps.into_iter().flat_map(|step| [excess(step), excess(-step)]).sum();
            1.0 / (1.0 + (-(logit(alone[i].clamp(1e-4, 0.9999)) + coupling * sum)).exp())
        };
        belief = estimate.voxels().par_iter().enumerate().map(update).collect();
    }
    belief
}

fn logit(p: f32) -> f32 {
    (p / (1.0 - p)).ln()
}
