//! A data set for training NBV-Net, made by the simulator: scans of random objects, a sample after each view.
//!
//! Start with [`make`]. The samples are the same for any number of threads and after interruptions.

mod config;
mod error;
mod folder;
mod npy;
mod sample;

pub use config::DatasetConfig;
pub use error::DatasetError;

use folder::Folder;
use nextview_sim::SimError;
use rayon::prelude::*;
use sample::Sample;
use std::ops::Range;
use std::path::Path;

/// Makes the files of a data set that are not in the folder yet: `dataset.toml`, and arrays that `numpy.load`
/// reads.
///
/// `progress` is called once for each object, from several threads. With `resume`, the folder may hold a part
/// of the same data set; without, it must not hold any.
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
        folder.write(first, &samples(objects, config.seed, &progress)?)?;
    }
    Ok(())
}

/// The samples of all objects, one object after the other, whichever is finished first.
fn samples(objects: Range<u32>, seed: u32, progress: impl Fn() + Sync) -> Result<Vec<Sample>, SimError> {
    let samples = |object| sample::samples(object, seed).inspect(|_| progress());
    let parts: Vec<Vec<Sample>> = objects.into_par_iter().map(samples).collect::<Result<_, _>>()?;
    Ok(parts.into_iter().flatten().collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nbv_net::{Grid, Network};

    /// The training framework's results for the first hundred grids of seed 0: for each a checksum and the
    /// logits. `training/nbv_net.py reference` writes it.
    const REFERENCE: &[u8] = include_bytes!("reference.bin");

    fn checksum(grid: &[u8]) -> u32 {
        let cells = grid.iter().zip(1_u32..);
        cells.fold(0, |sum, (&byte, number)| sum.wrapping_add(number.wrapping_mul(byte.into())))
    }

    #[test]
    fn the_network_gives_what_the_training_framework_gives() {
        let samples = samples(0..13, 0, || ()).unwrap();
        let network = Network::default();
        let (records, rest) = REFERENCE.as_chunks::<60>();
        assert!(records.len() == 100 && rest.is_empty() && samples.len() >= 100);
        let (mut n_compared, mut largest) = (0, 0.0_f32);
        for (record, sample) in records.iter().zip(&samples) {
            let (numbers, _) = record.as_chunks::<4>();
            // Random objects depend on the machine's sine and cosine.
            if u32::from_le_bytes(numbers[0]) == checksum(&sample.grid) {
                n_compared += 1;
                let logits = network.logits(&Grid::from_bytes(&sample.grid).unwrap());
                let errors =
                    logits.iter().zip(&numbers[1..]).map(|(a, b)| (a - f32::from_le_bytes(*b)).abs());
                largest = errors.fold(largest, f32::max);
            }
        }
        assert!(n_compared > 0 && largest < 1e-5, "{n_compared} compared, logits differ by up to {largest}");
        if n_compared < 100 {
            let name = "the_network_gives_what_the_training_framework_gives";
            eprintln!("SKIPPED {name}: {} of 100 grids come out otherwise on this machine", 100 - n_compared);
        }
    }

    /// On objects of another seed than it learned from.
    #[test]
    fn the_network_names_better_views_than_chance() {
        let samples = samples(0..20, 1, || ()).unwrap();
        let network = Network::default();
        let (mut named, mut mean) = (0.0, 0.0);
        for sample in &samples {
            let logits = network.logits(&Grid::from_bytes(&sample.grid).unwrap());
            let view = (0..logits.len()).max_by(|&a, &b| logits[a].total_cmp(&logits[b])).unwrap();
            let best = f64::from(*sample.gains.iter().max().unwrap());
            named += f64::from(sample.gains[view]) / best;
            mean +=
                sample.gains.iter().map(|&gain| f64::from(gain)).sum::<f64>() / best / logits.len() as f64;
        }
        let (named, mean) = (named / samples.len() as f64, mean / samples.len() as f64);
        assert!(
            samples.len() > 100 && named > 0.65 && mean < 0.5,
            "{named} of the best gain, by chance {mean}"
        );
    }
}
