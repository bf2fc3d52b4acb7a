use super::route::{Content, Doc, Method, Route};
use crate::app::App;
use crate::refusal::Refusal;
use axum::extract::{Path, State};
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use nextview_scan::{Fault, RESULT_FILES, result_file};
use std::sync::Arc;

pub(super) fn routes() -> Vec<Route> {
    let summary = "A file of the results, or of the current state of a scan under way: map, cloud, mesh, \
                   report, lists";
    let doc = Doc::new(summary, Content::of("application/octet-stream"));
    vec![Route::new("/scans/{id}/files/{name}").on(Method::Get, doc, get)]
}

async fn get(
    State(app): State<Arc<App>>,
    Path((id, name)): Path<(String, String)>,
) -> Result<Response, Refusal> {
    let scan = app.scans.find(&id)?;
    // A known name, so no other file can be requested.
    let Some(name) = RESULT_FILES.iter().copied().find(|known| *known == name) else {
        let name: String = name.chars().take(80).collect();
        let fault = Fault::of_value("name", name, format!("one of {}", RESULT_FILES.join(", ")));
        return Err(Refusal::new(StatusCode::NOT_FOUND, fault));
    };
    let bytes = scan.with(move |work| {
        if work.is_finished() {
            let path = work.dir().join(name);
            return std::fs::read(&path).map_err(|error| match error.kind() {
                std::io::ErrorKind::NotFound => Refusal::of(
                    StatusCode::NOT_FOUND,
                    format!("the scan has no {name}: it could not be made"),
                ),
                _ => Fault::from(error).in_file(&path).into(),
            });
        }
        if name == "report.html" {
            let fault = Fault::request("the report is made when the scan is finished");
            return Err(Refusal::new(
                StatusCode::CONFLICT,
                fault.with_remedy("finish it first: `POST …/finish`"),
            ));
        }
        let dir = work.dir().to_owned();
        let (scan, _) = work.under_way()?;
        let config = scan.config().kept_in(&dir);
        let made = result_file(name, &config, scan.scan());
        made.map_err(|fault| Refusal::new(StatusCode::CONFLICT, fault.within(name)))
    });
    let kind = match name.rsplit_once('.').map_or("", |(_, kind)| kind) {
        "html" => "text/html; charset=utf-8",
        "json" => "application/json",
        "csv" => "text/csv; charset=utf-8",
        "toml" | "jsonl" => "text/plain; charset=utf-8",
        _ => "application/octet-stream",
    };
    let named = format!("attachment; filename=\"{id}-{name}\"");
    Ok(([(header::CONTENT_TYPE, kind), (header::CONTENT_DISPOSITION, &named)], bytes.await?).into_response())
}
