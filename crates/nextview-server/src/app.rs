use crate::Limits;
use crate::access::Access;
use crate::refusal::Refusal;
use crate::room::BodyRoom;
use crate::scans::Scans;
use axum::http::StatusCode;
use nextview_scan::{Fault, memory};
use std::sync::Arc;
use tokio::sync::{Semaphore, watch};

/// The state shared by all requests.
pub(crate) struct App {
    pub limits: Limits,
    pub access: Access,
    /// The description of all routes.
    pub openapi: serde_json::Value,
    pub scans: Arc<Scans>,
    /// Memory for request bodies.
    pub bodies: Arc<BodyRoom>,
    /// Number of event streams that may still begin.
    pub streams: Arc<Semaphore>,
    /// Whether the server is shutting down.
    pub is_closing: watch::Receiver<bool>,
}

impl App {
    /// Fails if there is no room for another scan or frame.
    pub fn check_room(&self) -> Result<(), Refusal> {
        let most = self.limits.memory_mb;
        if let Some(now) = memory::now_mb().filter(|now| *now > most as f64) {
            let message = format!("the server uses {now:.0} MB of memory, and its limit is {most} MB");
            let fault = Fault::request(message).with_remedy("finish or delete scans");
            return Err(Refusal::new(StatusCode::SERVICE_UNAVAILABLE, fault));
        }
        let least = self.limits.free_disk_mb;
        if let Some(free) = self.scans.free_disk_mb().filter(|free| *free < least) {
            let message = format!("the server's disk has {free} MB free, but {least} MB must stay free");
            let fault = Fault::request(message).with_remedy("free space on the server's disk");
            return Err(Refusal::new(StatusCode::SERVICE_UNAVAILABLE, fault));
        }
        Ok(())
    }
}
