use super::route::{Content, Doc, Method, Route};
use crate::app::App;
use crate::refusal::Refusal;
use axum::extract::{Path, State};
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use nextview_export::{Format, export_files};
use nextview_scan::{Fault, Named};
use std::sync::Arc;

pub(super) fn routes() -> Vec<Route> {
    let summary = "The results of a finished scan as a tar archive in the format of another tool: bop, colmap, \
                   foundationpose, nerfstudio, obj, open3d, pcd or tum";
    let doc = Doc::new(summary, Content::of("application/x-tar"));
    vec![Route::new("/scans/{id}/export/{format}").on(Method::Get, doc, get)]
}

async fn get(
    State(app): State<Arc<App>>,
    Path((id, format)): Path<(String, String)>,
) -> Result<Response, Refusal> {
    let scan = app.scans.find(&id)?;
    let format: String = format.chars().take(80).collect();
    let format = Format::of_key("format", &format);
    let format = format.map_err(|fault| Refusal::new(StatusCode::NOT_FOUND, fault))?;
    let bytes = scan.with(move |work| {
        if !work.is_finished() {
            let fault = Fault::request("results can be exported when the scan is finished");
            return Err(Refusal::new(
                StatusCode::CONFLICT,
                fault.with_remedy("finish it first: `POST …/finish`"),
            ));
        }
        let exported = export_files(work.dir(), format);
        let (files, _) = exported.map_err(|faults| Refusal::new(StatusCode::CONFLICT, faults))?;
        Ok(archive(&files)?)
    });
    let named = format!("attachment; filename=\"{id}-{format}.tar\"");
    let kind = "application/x-tar";
    Ok(([(header::CONTENT_TYPE, kind), (header::CONTENT_DISPOSITION, &named)], bytes.await?).into_response())
}

/// Archives the files without times and owners.
fn archive(files: &[(String, Vec<u8>)]) -> Result<Vec<u8>, Fault> {
    let mut archive = tar::Builder::new(Vec::new());
    for (name, bytes) in files {
        let mut header = tar::Header::new_gnu();
        header.set_size(bytes.len() as u64);
        header.set_mode(0o644);
        archive.append_data(&mut header, name, bytes.as_slice())?;
    }
    Ok(archive.into_inner()?)
}
