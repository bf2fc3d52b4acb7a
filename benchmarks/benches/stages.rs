//! Wall time of every stage on the workload of the mesh that `NEXTVIEW_BENCH_OBJECT` names (default: the
//! built-in teapot).
//!
//!     cargo bench -p nextview-benchmarks

use divan::Bencher;
use nextview_benchmarks::stage::{Stage, stages};
use nextview_benchmarks::workload::Workload;
use std::sync::LazyLock;

static WORKLOAD: LazyLock<Workload> = LazyLock::new(|| {
    let object = std::env::var("NEXTVIEW_BENCH_OBJECT").unwrap_or_else(|_| "teapot".to_owned());
    Workload::around(&object).unwrap_or_else(|error| panic!("NEXTVIEW_BENCH_OBJECT={object}: {error}"))
});

fn main() {
    divan::main();
}

#[divan::bench(args = stages(), sample_count = 10, sample_size = 1)]
fn stage(bencher: Bencher, stage: &Stage) {
    bencher.bench_local(stage.prepare(&WORKLOAD));
}
