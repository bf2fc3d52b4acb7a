//! Trains the surface prior: `cargo run --release -p nextview-training -- OUT N_RANDOM N_VARIED [MESH ...]`.
//!
//! Scans `N_RANDOM` random objects and each mesh `N_VARIED` times, turned and stretched, and writes the
//! learned prior to OUT. The same arguments give the same bits. `docs/planner.md` states the arguments for
//! the library's own prior.

mod optimizer;
mod scans;

use nextview::prior::{Network, SurfacePrior, ViewingClass};
use nextview_sim::mesh::{self, Unit};
use optimizer::{Sample, loss, train};
use rayon::prelude::*;
use scans::{Source, Target};
use std::error::Error;
use std::path::Path;
use std::sync::Arc;

/// Samples after each view of a scan.
const N_STOPS: usize = 600;
const N_SHOWS: usize = 1200;

/// How often each sample is drawn.
const N_EPOCHS: usize = 4;

/// Random objects with seeds from here on are never learned from.
const HELD_OUT: u64 = 1 << 32;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [out, n_random, n_varied, meshes @ ..] = &arguments[..] else {
        return Err("usage: nextview-training OUT N_RANDOM N_VARIED [MESH ...]".into());
    };
    let mut sources: Vec<Source> = (0..n_random.parse()?).map(|seed| Source { mesh: None, seed }).collect();
    for path in meshes {
        let (mesh, _) = mesh::load(Path::new(path))?.to_metres(Unit::LongestSide(0.2))?;
        let mesh = Arc::new(mesh);
        sources.extend((0..n_varied.parse()?).map(|seed| Source { mesh: Some(mesh.clone()), seed }));
    }
    let held_out: Vec<Source> = (HELD_OUT..HELD_OUT + 20).map(|seed| Source { mesh: None, seed }).collect();

    let stops = train(&samples(&sources, Target::Stops, N_STOPS), 1, N_EPOCHS, 1);
    report("stops", &stops, 1, &samples(&held_out, Target::Stops, N_STOPS));

    // First from random views, then also from views that the prior learned so far chooses.
    let blank = vec![0.0; Network::n_numbers(ViewingClass::N)];
    let blank = Network::from_numbers(&blank, ViewingClass::N).ok_or("no network")?;
    let mut prior = SurfacePrior::new(stops.clone(), blank);
    let mut learned = Vec::new();
    for round in 0..2 {
        let part: Vec<Source> = sources.iter().skip(round).step_by(2).cloned().collect();
        learned.extend(samples(&part, Target::Shows(&prior), N_SHOWS));
        let shows = train(&learned, ViewingClass::N, N_EPOCHS, 2);
        let held_out = samples(&held_out, Target::Shows(&prior), N_SHOWS);
        report("shows", &shows, ViewingClass::N, &held_out);
        prior = SurfacePrior::new(stops.clone(), shows);
    }
    Ok(std::fs::write(out, prior.to_bytes())?)
}

/// The samples of all sources, one source after the other.
fn samples(sources: &[Source], target: Target<'_>, n_per_view: usize) -> Vec<Sample> {
    let parts: Vec<Vec<Sample>> =
        sources.par_iter().map(|source| source.samples(target, n_per_view)).collect();
    parts.concat()
}

fn report(name: &str, network: &Network, n_outputs: usize, held_out: &[Sample]) {
    println!("{name}: cross entropy {:.4} on objects held out", loss(network, n_outputs, held_out));
}
