//! Actual and wanted pose of a hand-held camera.

use super::route::{Content, Doc, Method, Route};
use crate::answers::{CameraPose, GuidanceAnswer, Tracking};
use crate::app::App;
use crate::body::receive_json;
use crate::frames::{FrameQuery, receive_frame};
use crate::refusal::Refusal;
use crate::scans::Scan;
use axum::Json;
use axum::body::Body;
use axum::extract::{Path, Query, State};
use axum::http::{HeaderMap, StatusCode};
use nextview::geometry::Pose;
use nextview_scan::{LiveScan, pose_of_rows, rows_of_pose};
use std::sync::Arc;

pub(super) fn routes() -> Vec<Route> {
    let guidance = Doc::new("The way from a pose to the next view", Content::json::<GuidanceAnswer>());
    let locate = Doc::new(
        "Locates an image on the surface known so far, and returns the way from there to the next view; the \
         image is not added to the scan",
        Content::json::<GuidanceAnswer>(),
    );
    let locate = locate.with_query::<FrameQuery>().taking(Content::of("multipart/form-data"));
    let locate = locate.taking(Content::of("image/png")).taking(Content::of("application/octet-stream"));
    vec![
        Route::new("/scans/{id}/guidance").on(
            Method::Post,
            guidance.taking(Content::json::<CameraPose>()),
            post_guidance,
        ),
        Route::new("/scans/{id}/locate").on(Method::Post, locate, post_locate),
    ]
}

async fn post_guidance(
    State(app): State<Arc<App>>,
    Path(id): Path<String>,
    headers: HeaderMap,
    body: Body,
) -> Result<Json<GuidanceAnswer>, Refusal> {
    let scan = app.scans.find(&id)?;
    let place: CameraPose = receive_json(&app, &headers, body, "the pose of the camera").await?;
    let pose = pose_of_rows("world_from_camera", &place.world_from_camera).map_err(Refusal::content)?;
    let listened = scan.clone();
    let answer = scan.with(move |work| guided(work.under_way()?.0, &pose, &listened));
    Ok(Json(answer.await?))
}

async fn post_locate(
    State(app): State<Arc<App>>,
    Path(id): Path<String>,
    Query(query): Query<FrameQuery>,
    headers: HeaderMap,
    body: Body,
) -> Result<Json<GuidanceAnswer>, Refusal> {
    let scan = app.scans.find(&id)?;
    let (posted, share) = receive_frame(&app, &headers, query, body).await?;
    let listened = scan.clone();
    let answer = scan.with(move |work| {
        let _share = share;
        let (scan, _) = work.under_way()?;
        let frame = posted.decode(&scan.config().camera)?;
        let found = scan.locate(&frame.depth);
        let tracking = Tracking {
            lost: found.is_err(),
            remedy: found.as_ref().err().and_then(|fault| fault.remedy.clone()),
        };
        listened.events.pass("tracking", &tracking);
        let pose = found.map_err(|fault| Refusal::new(StatusCode::CONFLICT, fault))?;
        guided(scan, &pose, &listened)
    });
    Ok(Json(answer.await?))
}

/// Returns the guidance from this pose, and sends it to listeners.
fn guided(scan: &mut LiveScan, pose: &Pose, listened: &Scan) -> Result<GuidanceAnswer, Refusal> {
    let guidance = scan.guidance(pose)?;
    let answer = GuidanceAnswer { world_from_camera: rows_of_pose(pose), guidance };
    listened.events.pass("pose", &answer);
    Ok(answer)
}
