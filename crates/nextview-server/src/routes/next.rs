use super::route::{Content, Doc, Method, Route};
use crate::answers::{Accept, Done, NextAnswer, NextState, Skip};
use crate::app::App;
use crate::body::receive_json;
use crate::refusal::Refusal;
use axum::Json;
use axum::body::Body;
use axum::extract::{Path, State};
use axum::http::{HeaderMap, StatusCode};
use nextview_scan::{Fault, LiveScan, ViewRecord};
use std::sync::Arc;

/// Most characters of a reason, which the journal keeps.
const LONGEST_REASON: usize = 1000;

pub(super) fn routes() -> Vec<Route> {
    vec![
        Route::new("/scans/{id}/next").on(
            Method::Get,
            Doc::new("The next view, and why; the same until a frame comes", Content::json::<NextAnswer>()),
            next,
        ),
        Route::new("/scans/{id}/skip").on(
            Method::Post,
            Doc::new("Never proposes a view again", Content::json::<Done>()).taking(Content::json::<Skip>()),
            skip,
        ),
        Route::new("/scans/{id}/accept").on(
            Method::Post,
            Doc::new("Lets the proposed view be given out", Content::json::<Done>())
                .taking(Content::json::<Accept>()),
            accept,
        ),
    ]
}

async fn next(State(app): State<Arc<App>>, Path(id): Path<String>) -> Result<Json<NextAnswer>, Refusal> {
    let scan = app.scans.find(&id)?;
    let listened = scan.clone();
    let answer = scan.with(move |work| {
        if work.is_finished() {
            let stop_reason = super::scans::record_so_far(work)?.stop_reason;
            return Ok(NextAnswer { state: NextState::Finished, view: None, stop_reason });
        }
        let (scan, about) = work.under_way()?;
        if about.is_paused {
            return Ok(NextAnswer { state: NextState::Paused, view: None, stop_reason: None });
        }
        let Some(view) = view_of(scan)? else {
            let stop_reason = scan.stop_reason();
            return Ok(NextAnswer { state: NextState::Finished, view: None, stop_reason });
        };
        let is_accepted = about.accepted_after == Some(scan.scan().steps.len());
        let state = if about.confirm_views && !is_accepted { NextState::Proposed } else { NextState::View };
        if work.is_news(view.view) {
            listened.events.tell("view", &view);
        }
        Ok(NextAnswer { state, view: Some(view), stop_reason: None })
    });
    Ok(Json(answer.await?))
}

fn view_of(scan: &mut LiveScan) -> Result<Option<ViewRecord>, Refusal> {
    let Some(next) = scan.next()? else { return Ok(None) };
    Ok(Some(scan.record_of(&next)?))
}

async fn skip(
    State(app): State<Arc<App>>,
    Path(id): Path<String>,
    headers: HeaderMap,
    body: Body,
) -> Result<Json<Done>, Refusal> {
    let scan = app.scans.find(&id)?;
    let skip: Skip = receive_json(&app, &headers, body, "the view to skip").await?;
    if skip.reason.chars().count() > LONGEST_REASON {
        let value = format!("{} characters", skip.reason.chars().count());
        return Err(Refusal::content(Fault::of_value("reason", value, format!("at most {LONGEST_REASON}"))));
    }
    let listened = scan.clone();
    let done = scan.with(move |work| {
        let dir = work.dir().to_owned();
        let (scan, about) = work.under_way()?;
        scan.skip(skip.view, &skip.reason)?;
        if about.accepted_after.take().is_some() {
            about.save(&dir)?;
        }
        listened.events.tell("skipped", &skip);
        Ok(Done { state: work.state() })
    });
    Ok(Json(done.await?))
}

async fn accept(
    State(app): State<Arc<App>>,
    Path(id): Path<String>,
    headers: HeaderMap,
    body: Body,
) -> Result<Json<Done>, Refusal> {
    let scan = app.scans.find(&id)?;
    let accepted: Accept = receive_json(&app, &headers, body, "the view to accept").await?;
    let listened = scan.clone();
    let done = scan.with(move |work| {
        let dir = work.dir().to_owned();
        let (scan, about) = work.under_way()?;
        let proposed = scan.next()?.map(|next| next.view);
        if proposed != Some(accepted.view) {
            let name = |view: Option<usize>| view.map_or("none".to_owned(), |view| view.to_string());
            let expected = proposed.map_or("no view: the scan is over".to_owned(), |view| {
                format!("{}, which is proposed", name(view))
            });
            let fault = Fault::of_value("view", name(accepted.view), expected);
            return Err(Refusal::new(StatusCode::CONFLICT, fault));
        }
        let before = about.accepted_after.replace(scan.scan().steps.len());
        about.save(&dir).inspect_err(|_| about.accepted_after = before)?;
        listened.events.tell("accepted", &accepted);
        Ok(Done { state: work.state() })
    });
    Ok(Json(done.await?))
}
