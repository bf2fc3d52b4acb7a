use crate::{Failure, stdout};
use indicatif::{HumanDuration, ProgressBar, ProgressState, ProgressStyle};
use std::fmt::Write;
use std::io::{IsTerminal, stderr};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Interval between lines if there is no terminal to show a bar on.
const BETWEEN_LINES: Duration = Duration::from_secs(30);

/// Progress of a campaign on stderr: a bar, or an occasional line.
pub(crate) struct CampaignProgress {
    pub(super) bar: ProgressBar,
    /// Start of the campaign, and the number of runs done before.
    begin: (Instant, Arc<AtomicU64>),
    /// Time of the last line; `None` with a bar.
    last_line: Option<Mutex<Instant>>,
}

impl CampaignProgress {
    /// Starts the progress of this number of runs.
    pub fn new(n_runs: usize) -> Self {
        let style = ProgressStyle::with_template("{pos} of {len} runs [{wide_bar}] {elapsed} ({left})");
        let style = style.expect("the template is well formed");
        let begin = (Instant::now(), Arc::new(AtomicU64::new(0)));
        let since = begin.clone();
        let left = move |state: &ProgressState, writer: &mut dyn Write| {
            // Before the first run there is no estimate; failing to draw a line is not an error.
            let _ = match time_left(&since, state.pos(), n_runs as u64) {
                Some(time) => write!(writer, "{:#} left", HumanDuration(time)),
                None => write!(writer, "preparing the first object"),
            };
        };
        let bar = ProgressBar::new(n_runs as u64).with_style(style.with_key("left", left));
        bar.enable_steady_tick(Duration::from_millis(200));
        let last_line = (!stderr().is_terminal()).then(|| Mutex::new(Instant::now()));
        Self { bar, begin, last_line }
    }

    /// Sets the number of runs done before.
    pub fn begin(&self, n_before: usize) {
        self.begin.1.store(n_before as u64, Ordering::Relaxed);
        self.bar.set_position(n_before as u64);
    }

    /// Advances by one run.
    pub fn step(&self) {
        self.bar.inc(1);
        let Some(last_line) = &self.last_line else { return };
        let mut last_line = last_line.lock().unwrap_or_else(PoisonError::into_inner);
        let (n_done, n_runs) = (self.bar.position(), self.bar.length().unwrap_or_default());
        if last_line.elapsed() >= BETWEEN_LINES && n_done < n_runs {
            *last_line = Instant::now();
            let left = time_left(&self.begin, n_done, n_runs).unwrap_or_default();
            eprintln!("{n_done} of {n_runs} runs, about {} left", HumanDuration(left));
        }
    }

    /// Prints to stdout, which may be the same terminal.
    pub fn print(&self, text: &str) -> Result<(), Failure> {
        self.bar.suspend(|| stdout::print(text))
    }
}

/// Estimates the time left from the mean over all runs since the beginning, because runs finish in bursts
/// after each object is rendered; `None` before the first.
fn time_left((begin, n_before): &(Instant, Arc<AtomicU64>), n_done: u64, n_runs: u64) -> Option<Duration> {
    let n_since = n_done.saturating_sub(n_before.load(Ordering::Relaxed));
    (n_since > 0).then(|| begin.elapsed().mul_f64((n_runs - n_done) as f64 / n_since as f64))
}

impl Drop for CampaignProgress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
