use super::events::Events;
use super::summary::ScanSummary;
use super::work::Work;
use crate::Limits;
use crate::refusal::Refusal;
use axum::http::StatusCode;
use nextview::Cancel;
use nextview_report::live::{LiveScene, SceneSource};
use nextview_scan::{Fault, ScanConfig};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use tokio::sync::{Mutex as AsyncMutex, Semaphore};

/// Limits on parallel computation, shared by all scans.
#[derive(Clone)]
pub(crate) struct Cores {
    /// Limit on requests to different scans.
    pub requests: Arc<Semaphore>,
    /// Limit on scenes, so that viewers do not slow down scans.
    pub scenes: Arc<Semaphore>,
}

/// The content of a scan's page.
pub(crate) enum PageContent {
    /// A copy from which the scene is made.
    UnderWay(Box<SceneSource>),
    /// The scene as JSON.
    Finished(Vec<u8>),
}

/// A scan of the server. Requests to it are processed one at a time, in order of arrival.
pub(crate) struct Scan {
    pub events: Events,
    work: Arc<AsyncMutex<Work>>,
    queue: Arc<Semaphore>,
    /// The content of its page, which is made in parallel with other requests.
    scene: Arc<AsyncMutex<LiveScene>>,
    cores: Cores,
    answer_time: Duration,
    /// State after the last completed request, to list it without waiting.
    summary: Mutex<ScanSummary>,
    cancel: Cancel,
}

impl Scan {
    pub fn new(id: String, run: String, work: Work, config: &ScanConfig, shared: (Cores, &Limits)) -> Self {
        let summary = ScanSummary {
            id,
            object: nextview_scan::short_name(&config.object),
            state: work.state(),
            n_frames: work.n_frames(),
            created: work.about.created.clone(),
        };
        let (cores, limits) = shared;
        Self {
            events: Events::new(run),
            cancel: work.cancel.clone(),
            work: Arc::new(AsyncMutex::new(work)),
            scene: Arc::default(),
            queue: Arc::new(Semaphore::new(limits.queue)),
            cores,
            answer_time: limits.answer_time,
            summary: Mutex::new(summary),
        }
    }

    /// The state after the last completed request.
    pub fn summary(&self) -> ScanSummary {
        self.summary.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Runs a closure on the scan after all earlier requests. It completes even if nobody waits for it any
    /// more.
    pub async fn with<T: Send + 'static>(
        self: &Arc<Self>,
        job: impl FnOnce(&mut Work) -> Result<T, Refusal> + Send + 'static,
    ) -> Result<T, Refusal> {
        let place = self.queue.clone().try_acquire_owned().map_err(|_| {
            let fault = Fault::request("too many requests to this scan are already waiting");
            Refusal::busy(StatusCode::TOO_MANY_REQUESTS, fault)
        })?;
        let scan = self.clone();
        let done = async move {
            let mut work = scan.work.clone().lock_owned().await;
            let core = scan.cores.requests.clone().acquire_owned().await;
            let done = tokio::task::spawn_blocking(move || {
                let _held = (place, core);
                work.look();
                let done = catch_unwind(AssertUnwindSafe(|| job(&mut work)));
                // Frames kept but not counted are observed when the scan is resumed.
                if done.as_ref().map_or(true, |done| done.as_ref().is_err_and(Refusal::is_cancelled)) {
                    work.forget();
                }
                scan.note(&work);
                done.unwrap_or_else(|_| Err(panicked()))
            });
            done.await.unwrap_or_else(|_| Err(panicked()))
        };
        tokio::time::timeout(self.answer_time, done).await.unwrap_or_else(|_| Err(self.too_late()))
    }

    /// The content of the page, with the views after number `after`. Meanwhile, frames are observed: they
    /// wait only for a copy.
    pub async fn scene(
        self: &Arc<Self>,
        shown: impl FnOnce(&mut Work) -> Result<PageContent, Refusal> + Send + 'static,
        after: usize,
    ) -> Result<Vec<u8>, Refusal> {
        // In this order, to ensure that no scene is older than the one before.
        let mut kept = self.scene.clone().lock_owned().await;
        let source = match self.with(shown).await? {
            PageContent::UnderWay(source) => source,
            PageContent::Finished(json) => {
                *kept = LiveScene::default();
                return Ok(json);
            }
        };
        let core = self.cores.scenes.clone().acquire_owned().await;
        let made = tokio::task::spawn_blocking(move || {
            let _held = core;
            // If this fails, no partial scene is kept.
            let mut scene = std::mem::take(&mut *kept);
            let json = scene.json(&source, after);
            *kept = scene;
            json.into_bytes()
        });
        made.await.map_err(|_| panicked())
    }

    /// Stops the current computation, because the scan is being deleted.
    pub fn cancel(&self) {
        self.cancel.cancel();
    }

    /// Resets the cancellation: the scan is not deleted after all.
    pub fn go_on(&self) {
        self.cancel.reset();
    }

    fn note(&self, work: &Work) {
        let mut summary = self.summary.lock().unwrap_or_else(PoisonError::into_inner);
        summary.state = work.state();
        summary.n_frames = work.n_frames().or(summary.n_frames);
    }

    fn too_late(&self) -> Refusal {
        let seconds = self.answer_time.as_secs();
        let fault =
            Fault::request(format!("the answer took more than {seconds} s; the server continues computing"));
        Refusal::busy(StatusCode::SERVICE_UNAVAILABLE, fault)
    }
}

fn panicked() -> Refusal {
    let fault = Fault::data("the server failed with an internal error; the scan on the disk is unchanged");
    Refusal::new(StatusCode::INTERNAL_SERVER_ERROR, fault.with_remedy("please report it, with the request"))
}

#[cfg(test)]
mod tests {
    use super::super::about::About;
    use super::*;

    /// After a panic, the state in memory is discarded, and the next request is answered.
    #[test]
    fn a_request_that_panics_is_answered_and_the_scan_goes_on() {
        let about = About {
            created: String::new(),
            confirm_views: false,
            is_paused: true,
            accepted_after: None,
            asked_after: None,
            config: String::new(),
        };
        let one = || Arc::new(Semaphore::new(1));
        let cores = Cores { requests: one(), scenes: one() };
        let work = Work::kept("no-such-folder".into(), about);
        let shared = (cores, &Limits::default());
        let scan = Arc::new(Scan::new("mug".into(), "run".into(), work, &ScanConfig::default(), shared));
        let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build().unwrap();
        for _ in 0..3 {
            let refusal = runtime.block_on(scan.with(|_| -> Result<(), Refusal> { panic!("on purpose") }));
            assert_eq!(refusal.unwrap_err().status, StatusCode::INTERNAL_SERVER_ERROR);
            assert!(runtime.block_on(scan.with(|work| Ok(work.about.is_paused))).unwrap());
        }
    }
}
