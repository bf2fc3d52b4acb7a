use super::route::{Content, Doc, Method, Route};
use crate::app::App;
use crate::refusal::Refusal;
use crate::scans::{EventStream, Scan, Told};
use axum::extract::{Path, State};
use axum::http::{HeaderMap, StatusCode};
use axum::response::sse::{Event, KeepAlive, Sse};
use futures_util::stream::{self, Stream, StreamExt};
use nextview_scan::Fault;
use std::convert::Infallible;
use std::sync::Arc;
use tokio::sync::{OwnedSemaphorePermit, watch};

pub(super) fn routes() -> Vec<Route> {
    let summary = "The events of a scan as they happen: frame, view, skipped, accepted, paused, continued, \
                   finished, deleted; pose and tracking while they are current; gap if a listener has missed \
                   events and must read the state again";
    vec![Route::new("/scans/{id}/events").on(
        Method::Get,
        Doc::new(summary, Content::of("text/event-stream")),
        events,
    )]
}

/// A listener and the resources it holds.
struct EventListener {
    scan: Arc<Scan>,
    stream: EventStream,
    is_closing: watch::Receiver<bool>,
    _place: OwnedSemaphorePermit,
}

async fn events(
    State(app): State<Arc<App>>,
    Path(id): Path<String>,
    headers: HeaderMap,
) -> Result<Sse<impl Stream<Item = Result<Event, Infallible>>>, Refusal> {
    let scan = app.scans.find(&id)?;
    let place = app.streams.clone().try_acquire_owned().map_err(|_| {
        let fault = Fault::request("as many clients are listening to events as the server has room for");
        Refusal::busy(StatusCode::SERVICE_UNAVAILABLE, fault)
    })?;
    let last = headers.get("last-event-id").and_then(|id| id.to_str().ok());
    let stream = scan.events.listen(last);
    let listener = EventListener { scan, stream, is_closing: app.is_closing.clone(), _place: place };
    let events = stream::unfold(listener, |mut listener| async move {
        let told = tokio::select! {
            told = listener.scan.events.next(&mut listener.stream) => told,
            _ = listener.is_closing.wait_for(|is_closing| *is_closing) => return None,
        };
        let events: Vec<_> = told.iter().map(|told| Ok(event(&listener.scan, told))).collect();
        Some((stream::iter(events), listener))
    });
    Ok(Sse::new(events.flatten()).keep_alive(KeepAlive::default()))
}

fn event(scan: &Scan, told: &Told) -> Event {
    Event::default().id(scan.events.id(told.number)).event(told.name).data(&told.data)
}
