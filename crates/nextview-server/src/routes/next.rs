use super::route::{Content, Doc, Method, Route};
use crate::answers::{Accept, Done, NextAnswer, NextState, Skip};
use crate::app::App;
use crate::body::receive_json;
use crate::refusal::Refusal;
use axum::Json;
use axum::body::Body;
use axum::extract::{Path, Query, State};
use axum::http::{HeaderMap, StatusCode};
use nextview_scan::Fault;
use schemars::JsonSchema;
use serde::Deserialize;
use std::sync::Arc;

/// Maximum number of characters of a reason, which the journal keeps.
const LONGEST_REASON: usize = 1000;

/// Maximum number of views of a batch.
const MOST_VIEWS: usize = 100;

/// Number of views.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct NextQuery {
    /// Number of views, including the next one, 1 to 100. The later ones are the current plan: after a frame,
    /// others may be better. By default, only the next view is returned.
    #[serde(default)]
    batch: Option<usize>,
}

pub(super) fn routes() -> Vec<Route> {
    vec![
        Route::new("/scans/{id}/next").on(
            Method::Get,
            Doc::new(
                "The next view, and the reasons for it; unchanged until a frame arrives",
                Content::json::<NextAnswer>(),
            )
            .with_query::<NextQuery>(),
            next,
        ),
        Route::new("/scans/{id}/skip").on(
            Method::Post,
            Doc::new("Excludes a view for the rest of the scan", Content::json::<Done>())
                .taking(Content::json::<Skip>()),
            skip,
        ),
        Route::new("/scans/{id}/accept").on(
            Method::Post,
            Doc::new("Accepts the proposed view, which is then given out", Content::json::<Done>())
                .taking(Content::json::<Accept>()),
            accept,
        ),
    ]
}

async fn next(
    State(app): State<Arc<App>>,
    Path(id): Path<String>,
    Query(NextQuery { batch }): Query<NextQuery>,
) -> Result<Json<NextAnswer>, Refusal> {
    let scan = app.scans.find(&id)?;
    if let Some(n) = batch.filter(|n| !(1..=MOST_VIEWS).contains(n)) {
        return Err(Refusal::content(Fault::of_value("batch", n, format!("1 to {MOST_VIEWS}"))));
    }
    let listened = scan.clone();
    let answer = scan.with(move |work| {
        if work.is_finished() {
            let stop_reason = super::scans::record_so_far(work)?.stop_reason;
            return Ok(NextAnswer::without_view(NextState::Finished, stop_reason));
        }
        if work.under_way()?.1.is_paused {
            return Ok(NextAnswer::without_view(NextState::Paused, None));
        }
        let next = work.next_view()?;
        let (scan, about) = work.under_way()?;
        let Some(next) = next else {
            return Ok(NextAnswer::without_view(NextState::Finished, scan.stop_reason()));
        };
        let view = scan.record_of(&next)?;
        let following = batch.map(|n| scan.following(&next, n - 1)).transpose()?;
        let is_accepted = about.accepted_after == Some(scan.scan().steps.len());
        let state = if about.confirm_views && !is_accepted { NextState::Proposed } else { NextState::View };
        if work.is_news(view.view) {
            listened.events.tell("view", &view);
        }
        Ok(NextAnswer { state, view: Some(view), following, stop_reason: None })
    });
    Ok(Json(answer.await?))
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
        let was_accepted = about.accepted_after.take().is_some();
        if about.asked_after.take().is_some() || was_accepted {
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
        let proposed = work.next_view()?.map(|next| next.view);
        let (scan, about) = work.under_way()?;
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
