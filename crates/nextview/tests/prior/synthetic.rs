//! Priors and maps drawn at random.

use glam::{IVec3, UVec3};
use nextview::Cancel;
use nextview::geometry::random::Random;
use nextview::geometry::{Lattice, VoxelBlock};
use nextview::map::{LogOdds, Snapshot};
use nextview::prior::{Network, SurfacePrior, ViewingClass};
use nextview::visibility::MeasuredParts;

/// Voxels of 1 cm of which so much is known.
pub fn snapshot(block: VoxelBlock, log_odds: impl Fn(IVec3) -> Option<f32>) -> Snapshot {
    Snapshot::from_fn(Lattice::new(0.01).unwrap(), block, |key| log_odds(key).map(LogOdds))
}

/// A box whose voxels are what chance makes them; of some seeds nearly all are alike.
pub fn random_snapshot(min: IVec3, dims: UVec3, seed: u64) -> Snapshot {
    let mut random = Random::new(seed, 1);
    let (unknown, occupied) = (random.unit().powi(2), random.unit().powi(3));
    let block = VoxelBlock::new(min, dims).unwrap();
    let mut state = || match (random.unit() < unknown, random.unit() < occupied) {
        (true, _) => None,
        (_, true) => Some(0.85),
        _ => Some(-0.4 * (1 + random.index(4)) as f32),
    };
    let states: Vec<Option<f32>> = (0..block.n_voxels()).map(|_| state()).collect();
    snapshot(block, |key| states[block.index(key).unwrap()])
}

/// A ball of which the +x side was measured, with free space around that side; the rest unknown.
pub fn half_seen_ball() -> Snapshot {
    let lattice = Lattice::new(0.01).unwrap();
    snapshot(VoxelBlock::new(IVec3::splat(-8), UVec3::splat(16)).unwrap(), |key| {
        let center = lattice.center(key);
        let radius = center.length();
        match center.x > 0.0 {
            true if (0.04..0.052).contains(&radius) => Some(0.85),
            true if radius >= 0.052 => Some(-0.4),
            _ => None,
        }
    })
}

/// Where surface was measured is not known: no frame is.
pub fn nothing_measured(snapshot: &Snapshot) -> MeasuredParts {
    MeasuredParts::new(&[], snapshot, &Cancel::default()).unwrap()
}

/// A prior that learned nothing: its weights are chance.
pub fn prior(seed: u64) -> SurfacePrior {
    SurfacePrior::new(network(seed, 1), network(seed + 1, ViewingClass::N))
}

/// A prior by which everything is as probable everywhere.
pub fn even_prior(stops: f32, shows: f32) -> SurfacePrior {
    SurfacePrior::new(even_network(stops, 1), even_network(shows, ViewingClass::N))
}

/// Only the last biases are not 0.
fn even_network(probability: f32, n_outputs: usize) -> Network {
    let mut numbers = vec![0.0; Network::n_numbers(n_outputs)];
    let n_others = numbers.len() - n_outputs;
    numbers[n_others..].fill((probability / (1.0 - probability)).ln());
    Network::from_numbers(&numbers, n_outputs).unwrap()
}

fn network(seed: u64, n_outputs: usize) -> Network {
    let mut random = Random::new(seed, 2);
    let numbers: Vec<f32> =
        (0..Network::n_numbers(n_outputs)).map(|_| random.range(-0.7, 0.7) as f32).collect();
    Network::from_numbers(&numbers, n_outputs).unwrap()
}
