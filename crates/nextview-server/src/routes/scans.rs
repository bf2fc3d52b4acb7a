use super::route::{Content, Doc, Method, Route};
use crate::answers::{Deleted, ScanAnswer, record_of};
use crate::app::App;
use crate::body::{is_kind, receive, wrong_kind};
use crate::refusal::Refusal;
use crate::scans::{NewScan, Scan, ScanSummary, Work};
use axum::Json;
use axum::body::Body;
use axum::extract::{Path, State};
use axum::http::{HeaderMap, StatusCode, header};
use nextview_scan::{Fault, Measured, ScanConfig, ScanRecord};
use schemars::JsonSchema;
use std::sync::Arc;

/// A new scan: the keys of a configuration with its section `live`, and three of the server's own.
#[derive(JsonSchema)]
#[expect(dead_code, reason = "describes what `NewScan::from_json` reads")]
struct NewScanBody {
    /// Id of the scan in paths, 1 to 64 of a-z, 0-9, - and _; by default, one is generated.
    id: Option<String>,
    /// Whether a proposed view must be accepted before it is returned. Default false.
    confirm_views: Option<bool>,
    /// The finished scan of the same object before it was turned, which provides the defaults of all keys.
    after: Option<String>,
    #[schemars(flatten)]
    config: ScanConfig,
}

pub(super) fn routes() -> Vec<Route> {
    let create = Doc::new("Creates a scan", Content::json::<ScanAnswer>());
    vec![
        Route::new("/scans")
            .on(Method::Get, Doc::new("All scans", Content::json::<Vec<ScanSummary>>()), list)
            .on(Method::Post, create.taking(Content::json::<NewScanBody>()).creating(), post),
        Route::new("/scans/{id}")
            .on(Method::Get, Doc::new("A scan and its record so far", Content::json::<ScanAnswer>()), get)
            .on(
                Method::Delete,
                Doc::new("Removes a scan with all its files", Content::json::<Deleted>()),
                delete,
            ),
        Route::new("/scans/{id}/record").on(
            Method::Get,
            Doc::new("The record so far", Content::json::<ScanRecord>()),
            record,
        ),
    ]
}

async fn list(State(app): State<Arc<App>>) -> Json<Vec<ScanSummary>> {
    Json(app.scans.list())
}

async fn post(
    State(app): State<Arc<App>>,
    headers: HeaderMap,
    body: Body,
) -> Result<(StatusCode, Json<ScanAnswer>), Refusal> {
    let kind = headers.get(header::CONTENT_TYPE).map(|kind| kind.as_bytes());
    if kind.is_some_and(|kind| !is_kind(kind, "application/json")) {
        return Err(wrong_kind(kind, "application/json"));
    }
    app.check_room()?;
    let received = receive(&app, &headers, body).await?;
    let creating = app.clone();
    // Completed even if nobody waits for it: half a scan is useless.
    let created =
        tokio::task::spawn_blocking(move || creating.scans.create(NewScan::from_json(&received.bytes)?));
    let failed =
        |_| Refusal::new(StatusCode::INTERNAL_SERVER_ERROR, Fault::data("the scan cannot be created"));
    let scan = created.await.map_err(failed)??;
    Ok((StatusCode::CREATED, Json(answer(&scan).await?)))
}

async fn get(State(app): State<Arc<App>>, Path(id): Path<String>) -> Result<Json<ScanAnswer>, Refusal> {
    Ok(Json(answer(&app.scans.find(&id)?).await?))
}

async fn answer(scan: &Arc<Scan>) -> Result<ScanAnswer, Refusal> {
    let (confirm_views, record, damage) = scan
        .with(|work| {
            let record = record_so_far(work)?; // resumes it
            Ok((work.about.confirm_views, record, work.damage()))
        })
        .await?;
    Ok(ScanAnswer { summary: scan.summary(), confirm_views, record, damage })
}

async fn record(State(app): State<Arc<App>>, Path(id): Path<String>) -> Result<Json<ScanRecord>, Refusal> {
    Ok(Json(app.scans.find(&id)?.with(record_so_far).await?))
}

/// The record, from its file if the scan is finished.
pub(super) fn record_so_far(work: &mut Work) -> Result<ScanRecord, Refusal> {
    if work.is_finished() {
        let bytes = std::fs::read(work.dir().join("record.json")).map_err(Fault::from)?;
        return Ok(record_of(&bytes)?);
    }
    let (scan, _) = work.under_way()?;
    Ok(scan.scan().record(scan.config(), Measured::Nothing)?)
}

async fn delete(State(app): State<Arc<App>>, Path(id): Path<String>) -> Result<Json<Deleted>, Refusal> {
    let leaving = app.scans.leave(&id)?;
    let scan = leaving.scan.clone();
    scan.with(move |work| {
        work.delete()?;
        leaving.gone();
        Ok(())
    })
    .await?;
    scan.events.tell("deleted", &serde_json::json!({}));
    Ok(Json(Deleted { deleted: id }))
}
