//! Trains the surface prior: `cargo run --release -p nextview-training -- OUT N_RANDOM [N_VARIED MESH ...]
//! ...`, and the policy of the planner kaba: `cargo run --release -p nextview-training -- kaba OUT
//! N_EPISODES`.
//!
//! Scans `N_RANDOM` random objects, and each mesh, rotated and stretched, as often as given by the last
//! `N_VARIED` before it, and writes the learned prior to OUT. The same arguments give the same bits.
//! `docs/planner.md` states the arguments for the library's own prior.

mod housing;
mod kaba;
mod optimizer;
mod scans;

use nextview::prior::{Network, SurfacePrior, ViewingClass};
use nextview_sim::mesh::{self, Unit};
use nextview_sim::random_object::seeds;
use optimizer::{VoxelSample, loss, train};
use rayon::prelude::*;
use scans::{Source, Target};
use std::error::Error;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

/// Number of samples after each view of a scan.
const N_STOPS: usize = 600;
const N_SHOWS: usize = 1200;

/// Number of parts of the objects: each is scanned with the prior learned from the earlier ones.
const N_ROUNDS: usize = 3;

/// Number of times each sample is drawn.
const N_EPOCHS: usize = 4;

/// Number of training objects per held-out random object on which the loss is reported.
const N_PER_HELD_OUT: usize = 12;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [out, n_random, meshes @ ..] = &arguments[..] else {
        return Err(
            "usage: nextview-training OUT N_RANDOM [N_VARIED MESH ...] ... | kaba OUT N_EPISODES".into()
        );
    };
    if let ("kaba", [n_episodes]) = (out.as_str(), meshes) {
        let policy = kaba::learn(n_episodes.parse()?);
        kaba::compare(&policy);
        return Ok(std::fs::write(n_random, policy.to_json())?);
    }
    let n_random: usize = n_random.parse()?;
    let mut sources = random_objects(seeds::PRIOR, n_random)?;
    let mut n_varied = None;
    for argument in meshes {
        if let Ok(n) = argument.parse() {
            n_varied = Some(n);
            continue;
        }
        let n_varied = n_varied.ok_or_else(|| format!("{argument} comes before a number of variations"))?;
        let (mesh, _) = mesh::load(Path::new(argument))?.to_metres(Unit::LongestSide(0.2))?;
        let mesh = Arc::new(mesh);
        sources.extend((0..n_varied).map(|seed| Source { mesh: Some(mesh.clone()), seed }));
    }
    let held_out = random_objects(seeds::PRIOR_HELD_OUT, n_random.div_ceil(N_PER_HELD_OUT))?;

    let stops = train(&samples(&sources, Target::Stops, N_STOPS), 1, N_EPOCHS, 1);
    report("stops", &stops, 1, &samples(&held_out, Target::Stops, N_STOPS));

    // First from random views, then also from views chosen by the current prior.
    let blank = vec![0.0; Network::n_numbers(ViewingClass::N)];
    let blank = Network::from_numbers(&blank, ViewingClass::N).ok_or("no network")?;
    let mut prior = SurfacePrior::new(stops.clone(), blank);
    let mut learned = Vec::new();
    for round in 0..N_ROUNDS {
        let part: Vec<Source> = sources.iter().skip(round).step_by(N_ROUNDS).cloned().collect();
        learned.extend(samples(&part, Target::Shows(&prior), N_SHOWS));
        let shows = train(&learned, ViewingClass::N, N_EPOCHS, 2);
        let held_out = samples(&held_out, Target::Shows(&prior), N_SHOWS);
        report("shows", &shows, ViewingClass::N, &held_out);
        prior = SurfacePrior::new(stops.clone(), shows);
    }
    Ok(std::fs::write(out, prior.to_bytes())?)
}

/// The first random objects of a range of seeds; fails if it has fewer.
fn random_objects(seeds: Range<u64>, n: usize) -> Result<Vec<Source>, String> {
    let n_seeds = seeds.end - seeds.start;
    if n as u64 > n_seeds {
        return Err(format!("N_RANDOM is {n}, expected at most {n_seeds}: other seeds are for other uses"));
    }
    Ok(seeds.take(n).map(|seed| Source { mesh: None, seed }).collect())
}

/// The samples of all sources, one source after the other.
fn samples(sources: &[Source], target: Target<'_>, n_per_view: usize) -> Vec<VoxelSample> {
    let parts: Vec<Vec<VoxelSample>> =
        sources.par_iter().map(|source| source.samples(target, n_per_view)).collect();
    parts.concat()
}

fn report(name: &str, network: &Network, n_outputs: usize, held_out: &[VoxelSample]) {
    println!("{name}: cross entropy {:.4} on objects held out", loss(network, n_outputs, held_out));
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The recipe of the committed weights: random objects with the seeds 0 to 199, none of which has a name.
    #[test]
    fn training_objects_are_those_of_the_committed_weights_and_have_no_names() {
        let seeds_of = |range, n| -> Vec<u64> {
            random_objects(range, n).unwrap().iter().map(|source| source.seed).collect()
        };
        assert_eq!(seeds_of(seeds::PRIOR, 200), (0..200).collect::<Vec<_>>());
        assert_eq!(seeds_of(seeds::PRIOR_HELD_OUT, 2), [1 << 32, (1 << 32) + 1]);
        assert!(!seeds_of(seeds::PRIOR, 200).iter().any(|seed| seeds::NAMED.contains(seed)));
        assert!(
            random_objects(seeds::PRIOR, (1 << 32) + 1).unwrap_err().starts_with("N_RANDOM is 4294967297")
        );
    }
}
