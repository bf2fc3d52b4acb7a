//! Writes the shards of a large, synthetic campaign, to measure how many records are processed.
//!
//! ```sh
//! cargo run --release -p nextview-campaign --example many_runs -- FOLDER N_OBJECTS N_SEEDS N_SHARDS [DRAW]
//! nextview merge FOLDER/* --out whole
//! ```
//!
//! It has five variants: 1000 objects and 100 seeds make 500,000 runs. A small scan is done once; every
//! record is that of this scan with other numbers. Campaigns of another DRAW (default: 0) have the same runs
//! with other numbers, to compare them.

mod shards;

use std::error::Error;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [folder, numbers @ ..] = &args[..] else {
        return Err("expected FOLDER N_OBJECTS N_SEEDS N_SHARDS [DRAW]".into());
    };
    let numbers: Vec<usize> = numbers.iter().map(|number| number.parse()).collect::<Result<_, _>>()?;
    let ([n_objects, n_seeds, n_shards], draw) = match numbers[..] {
        [n_objects, n_seeds, n_shards] => ([n_objects, n_seeds, n_shards], 0),
        [n_objects, n_seeds, n_shards, draw] => ([n_objects, n_seeds, n_shards], draw),
        _ => return Err("expected three or four numbers".into()),
    };
    let shards = shards::write(Path::new(folder), [n_objects, n_seeds, n_shards], draw as u64)?;
    println!("{} shards in {folder}", shards.len());
    Ok(())
}
