use super::route::{Content, Doc, Method, Route};
use crate::answers::FrameAnswer;
use crate::app::App;
use crate::frames::{FrameHead, FrameQuery, receive_frame};
use crate::refusal::Refusal;
use axum::Json;
use axum::body::Body;
use axum::extract::{Path, Query, State};
use axum::http::{HeaderMap, StatusCode};
use nextview_scan::Fault;
use schemars::JsonSchema;
use std::sync::Arc;

/// The parts of a frame.
#[derive(JsonSchema)]
#[expect(dead_code, reason = "describes what is received")]
struct FrameParts {
    /// Everything except the images, as JSON.
    frame: FrameHead,
    /// PNG with 16-bit pixels, without colour, of the camera's size.
    depth: String,
    /// PNG or JPEG with 8 bits each of red, green and blue, of the same size.
    color: Option<String>,
    /// PNG with 8-bit pixels, of the same size: 0 marks pixels that miss the object.
    mask: Option<String>,
}

pub(super) fn routes() -> Vec<Route> {
    let parts = Content { kind: "multipart/form-data", ..Content::json::<FrameParts>() };
    let doc =
        Doc::new("Adds a frame: it is on the disk before the answer is sent", Content::json::<FrameAnswer>());
    let doc = doc.with_query::<FrameQuery>().taking(parts);
    let doc = doc.taking(Content::of("image/png")).taking(Content::of("application/octet-stream"));
    vec![Route::new("/scans/{id}/frames").on(Method::Post, doc, post)]
}

async fn post(
    State(app): State<Arc<App>>,
    Path(id): Path<String>,
    Query(query): Query<FrameQuery>,
    headers: HeaderMap,
    body: Body,
) -> Result<Json<FrameAnswer>, Refusal> {
    let scan = app.scans.find(&id)?;
    app.check_room()?;
    let (posted, share) = receive_frame(&app, &headers, query, body).await?;
    let (most, listened) = (app.limits.frames, scan.clone());
    let answer = scan.with(move |work| {
        let _share = share;
        let (scan, _) = work.under_way()?;
        posted.head.id()?;
        let frame = posted.decode(&scan.config().camera)?;
        let known = scan.known(&frame).map_err(|fault| Refusal::new(StatusCode::CONFLICT, fault))?;
        if let Some(step) = known {
            return Ok(FrameAnswer { duplicate: true, step: step.clone() });
        }
        if scan.scan().steps.len() >= most {
            let fault = Fault::of_value("frames", most + 1, format!("at most {most} in a scan"));
            return Err(Refusal::new(StatusCode::CONFLICT, fault.with_remedy("finish the scan")));
        }
        let step = scan.observe(frame)?.clone();
        listened.events.tell("frame", &step);
        Ok(FrameAnswer { duplicate: false, step })
    });
    Ok(Json(answer.await?))
}
