//! Data sets for training the networks, made by the simulator: scans of random objects, with a sample after
//! each view.
//!
//! Start with [`make`]. The samples do not depend on the number of threads or on interruptions.

mod config;
mod error;
mod folder;
mod network_name;
mod npy;
mod sample;

pub use config::DatasetConfig;
pub use error::DatasetError;
pub use network_name::NetworkName;

use folder::Folder;
use nextview_sim::SimError;
use rayon::prelude::*;
use sample::TrainingSample;
use std::ops::Range;
use std::path::Path;

/// Makes the missing files of a data set: `dataset.toml`, and arrays for `numpy.load`.
///
/// `progress` is called once per object, from several threads. With `resume`, the folder may hold a part of
/// the same data set; otherwise it must not hold any.
pub fn make(
    config: &DatasetConfig,
    folder: &Path,
    resume: bool,
    progress: impl Fn() + Sync,
) -> Result<(), DatasetError> {
    let folder = Folder::open(folder, config, resume)?;
    for first in (0..config.objects).step_by(DatasetConfig::PER_FILE as usize) {
        let objects = first..config.objects.min(first + DatasetConfig::PER_FILE);
        if folder.has(first) {
            objects.for_each(|_| progress());
            continue;
        }
        let samples = samples(config, objects, &progress)?;
        folder.write(first, config.network, &samples)?;
    }
    Ok(())
}

/// The samples of all objects, in the order of the objects.
fn samples(
    config: &DatasetConfig,
    objects: Range<u32>,
    progress: impl Fn() + Sync,
) -> Result<Vec<TrainingSample>, SimError> {
    let samples = |object| sample::samples(config.network, object, config.seed).inspect(|_| progress());
    let parts: Vec<Vec<TrainingSample>> = objects.into_par_iter().map(samples).collect::<Result<_, _>>()?;
    Ok(parts.into_iter().flatten().collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Grid;
    use crate::pc_nbv::{Cloud, views};
    use crate::{nbv_net, nbv_regression, pc_nbv};

    fn samples_of(network: NetworkName, objects: Range<u32>, seed: u32) -> Vec<TrainingSample> {
        samples(&DatasetConfig { network, objects: objects.end, seed }, objects, || ()).unwrap()
    }

    /// Minimum number of equal inputs of a hundred. Random objects depend on the machine's sine and cosine,
    /// which differ in the last bit of few values; if more than a tenth of the inputs differ, the inputs
    /// themselves have changed.
    const LEAST_COMPARED: usize = 90;

    /// Compares a grid's network with the training framework, which wrote a checksum and `N` outputs for the
    /// first hundred grids of seed 0 to a `reference` file. The largest difference must be below `tolerance`.
    fn check<const N: usize>(
        (network, reference, tolerance): (NetworkName, &[u8], f32),
        input_sum: impl Fn(&[u8]) -> u32,
        outputs: impl Fn(&[u8]) -> [f32; N],
    ) {
        let samples = samples_of(network, 0..13, 0);
        let records = reference.chunks_exact(4 * (N + 1));
        assert!(records.len() == 100 && records.remainder().is_empty() && samples.len() >= 100);
        let (mut n_compared, mut largest) = (0, 0.0_f32);
        for (record, sample) in records.zip(&samples) {
            let (numbers, _) = record.as_chunks::<4>();
            if u32::from_le_bytes(numbers[0]) == input_sum(&sample.input) {
                n_compared += 1;
                let errors = outputs(&sample.input).into_iter().zip(&numbers[1..]);
                largest = errors.map(|(a, b)| (a - f32::from_le_bytes(*b)).abs()).fold(largest, f32::max);
            }
        }
        println!("{network:?}: {n_compared} of 100 inputs compared, outputs differ by up to {largest}");
        assert!(
            n_compared >= LEAST_COMPARED && largest < tolerance,
            "{n_compared} of 100 inputs compared, expected at least {LEAST_COMPARED}; outputs differ by up to {largest}"
        );
    }

    /// The sum of all bytes, each times its number, from 1.
    fn checksum(bytes: &[u8]) -> u32 {
        let cells = bytes.iter().zip(1_u32..);
        cells.fold(0, |sum, (&byte, number)| sum.wrapping_add(number.wrapping_mul(byte.into())))
    }

    fn grid(input: &[u8]) -> Grid {
        Grid::from_bytes(input).unwrap()
    }

    /// The number of object voxels, and the input of PC-NBV.
    fn cloud(input: &[u8]) -> (u32, Cloud, [bool; views::N_VIEWS]) {
        let (surface, rest) = input.split_first_chunk().unwrap();
        let (visited, points) = rest.split_first_chunk().unwrap();
        let (numbers, _) = points.as_chunks::<4>();
        let numbers: Vec<f32> = numbers.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect();
        let (points, _) = numbers.as_chunks();
        let cloud = Cloud::from_points(points.to_vec()).unwrap();
        (u32::from_le_bytes(*surface), cloud, visited.map(|visited| visited == 1))
    }

    #[test]
    fn nbv_net_gives_what_the_training_framework_gives() {
        let reference = include_bytes!("../nbv_net/reference.bin");
        let network = nbv_net::Network::default();
        check((NetworkName::NbvNet, reference, 1e-5), checksum, |input| network.logits(&grid(input)));
    }

    #[test]
    fn nbv_regression_gives_what_the_training_framework_gives() {
        let reference = include_bytes!("../nbv_regression/reference.bin");
        let network = nbv_regression::Network::default();
        check((NetworkName::NbvRegression, reference, 1e-5), checksum, |input| network.outputs(&grid(input)));
    }

    /// Neighbours that are almost equally near have another order there, and cause small changes.
    #[test]
    fn pc_nbv_gives_what_the_training_framework_gives() {
        let reference = include_bytes!("../pc_nbv/reference.bin");
        let network = pc_nbv::Network::default();
        let gains = |input: &[u8]| {
            let (_, cloud, visited) = cloud(input);
            network.gains(&cloud, &visited)
        };
        check((NetworkName::PcNbv, reference, 1e-3), |input| checksum(&input[4..]), gains);
    }

    /// The mean gain of the view that a network chooses, and of all views, as shares of the best view's gain,
    /// on objects with another seed than its training.
    fn judge(network: NetworkName, view: impl Fn(&TrainingSample) -> usize) -> [f64; 2] {
        let samples = samples_of(network, 0..20, 1);
        let (mut named, mut mean) = (0.0, 0.0);
        for sample in &samples {
            let best = f64::from(*sample.gains.iter().max().unwrap());
            named += f64::from(sample.gains[view(sample)]) / best;
            let total: f64 = sample.gains.iter().map(|&gain| f64::from(gain)).sum();
            mean += total / best / sample.gains.len() as f64;
        }
        assert!(samples.len() > 100);
        [named, mean].map(|total| total / samples.len() as f64)
    }

    fn largest(scores: &[f32]) -> usize {
        (0..scores.len()).max_by(|&a, &b| scores[a].total_cmp(&scores[b])).unwrap()
    }

    #[test]
    fn nbv_net_names_better_views_than_chance() {
        let network = nbv_net::Network::default();
        let found = judge(NetworkName::NbvNet, |sample| largest(&network.logits(&grid(&sample.input))));
        assert!(found[0] > 0.65 && found[1] < 0.5, "of the best gain, and by chance: {found:?}");
    }

    #[test]
    fn nbv_regression_names_better_views_than_chance() {
        let (network, directions) =
            (nbv_regression::Network::default(), NetworkName::NbvRegression.directions());
        let found = judge(NetworkName::NbvRegression, |sample| {
            let direction = network.direction(&grid(&sample.input));
            let cosines = directions.iter().map(|view| view.dot(direction) as f32);
            largest(&cosines.collect::<Vec<f32>>())
        });
        assert!(found[0] > 0.6 && found[1] < 0.5, "of the best gain, and by chance: {found:?}");
    }

    #[test]
    fn pc_nbv_names_better_views_than_chance() {
        let network = pc_nbv::Network::default();
        let found = judge(NetworkName::PcNbv, |sample| {
            let (_, cloud, visited) = cloud(&sample.input);
            largest(&network.gains(&cloud, &visited))
        });
        assert!(found[0] > 0.65 && found[1] < 0.5, "of the best gain, and by chance: {found:?}");
    }
}
