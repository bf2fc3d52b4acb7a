use super::route::{Content, Doc, Method, Route};
use crate::answers::{Done, FinishAnswer};
use crate::app::App;
use crate::refusal::Refusal;
use axum::Json;
use axum::extract::{Path, State};
use nextview_scan::RESULT_FILES;
use serde_json::json;
use std::sync::Arc;

pub(super) fn routes() -> Vec<Route> {
    vec![
        Route::new("/scans/{id}/pause").on(
            Method::Post,
            Doc::new("Pauses the scan: it gives out no views until it is continued", Content::json::<Done>()),
            pause,
        ),
        Route::new("/scans/{id}/continue").on(
            Method::Post,
            Doc::new("Continues a paused scan", Content::json::<Done>()),
            go_on,
        ),
        Route::new("/scans/{id}/finish").on(
            Method::Post,
            Doc::new(
                "Ends the scan and writes its results; repeating the request changes nothing",
                Content::json::<FinishAnswer>(),
            ),
            finish,
        ),
    ]
}

async fn pause(app: State<Arc<App>>, id: Path<String>) -> Result<Json<Done>, Refusal> {
    set_paused(app, id, true).await
}

async fn go_on(app: State<Arc<App>>, id: Path<String>) -> Result<Json<Done>, Refusal> {
    set_paused(app, id, false).await
}

async fn set_paused(
    State(app): State<Arc<App>>,
    Path(id): Path<String>,
    is_paused: bool,
) -> Result<Json<Done>, Refusal> {
    let scan = app.scans.find(&id)?;
    let listened = scan.clone();
    let done = scan.with(move |work| {
        let dir = work.dir().to_owned();
        let (_, about) = work.under_way()?;
        if about.is_paused != is_paused {
            about.is_paused = is_paused;
            about.save(&dir).inspect_err(|_| about.is_paused = !is_paused)?;
            listened.events.tell(if is_paused { "paused" } else { "continued" }, &json!({}));
        }
        Ok(Done { state: work.state() })
    });
    Ok(Json(done.await?))
}

async fn finish(State(app): State<Arc<App>>, Path(id): Path<String>) -> Result<Json<FinishAnswer>, Refusal> {
    let scan = app.scans.find(&id)?;
    let listened = scan.clone();
    let answer = scan.with(move |work| {
        let was_finished = work.is_finished();
        let problems = work.finish()?;
        let problems =
            problems.iter().flat_map(|faults| faults.iter()).map(|fault| fault.message.clone()).collect();
        let record = super::scans::record_so_far(work)?;
        let files = RESULT_FILES.iter().filter(|name| work.dir().join(name).is_file());
        let answer = FinishAnswer { record, files: files.map(|name| (*name).to_owned()).collect(), problems };
        if !was_finished {
            listened.events.tell("finished", &json!({ "stop_reason": answer.record.stop_reason }));
        }
        Ok(answer)
    });
    Ok(Json(answer.await?))
}
