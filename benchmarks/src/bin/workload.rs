//! Writes the workload for the peers.
//!
//!     cargo run --release -p nextview-benchmarks --bin workload -- OBJECT FOLDER
//!
//! OBJECT is a mesh file or the name of a built-in object. With the variable QUICK, the workload is tiny.

use nextview_benchmarks::is_quick;
use nextview_benchmarks::network::RayNetwork;
use nextview_benchmarks::workload::Workload;
use std::error::Error;
use std::path::PathBuf;

fn main() -> Result<(), Box<dyn Error>> {
    let mut args = std::env::args().skip(1);
    let (Some(object), Some(folder)) = (args.next(), args.next().map(PathBuf::from)) else {
        return Err("usage: workload OBJECT FOLDER".into());
    };
    std::fs::create_dir_all(&folder)?;
    // An existing workload from another source is only completed.
    let workload = if folder.join("mesh0.bin").exists() {
        Workload::read(&folder)?
    } else {
        let whole = Workload::around(&object)?;
        let workload = if is_quick() { whole.thinned()? } else { whole };
        workload.write(&folder)?;
        workload
    };
    for (name, n_rays) in [("small", 19_177), ("large", 148_428)] {
        let network = RayNetwork::of(&workload, n_rays);
        eprintln!(
            "network of {} rays, {} edges, {} views of the optimal flow",
            network.view_of_ray.len(),
            network.edges.len(),
            network.solve().len()
        );
        network.write(&folder.join(format!("network_{name}.bin")))?;
    }
    Ok(())
}
