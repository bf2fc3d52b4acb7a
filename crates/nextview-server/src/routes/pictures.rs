use super::route::{Content, Doc, Method, Route};
use crate::app::App;
use crate::refusal::Refusal;
use crate::scans::Work;
use axum::extract::{Path, Query, State};
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use nextview_report::live::SceneSource;
use nextview_report::{color_png, depth_png};
use nextview_scan::{Fault, LiveScan};
use schemars::JsonSchema;
use serde::Deserialize;
use std::sync::Arc;

/// Which part of a scene.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct SceneQuery {
    /// Number of frames that the page has already. Default 0.
    #[serde(default)]
    after: usize,
}

pub(super) fn routes() -> Vec<Route> {
    let png = || Content::of("image/png");
    let scene = Doc::new("The scan as the page draws it", Content::json::<serde_json::Value>());
    vec![
        Route::new("/scans/{id}/scene").on(Method::Get, scene.with_query::<SceneQuery>(), get_scene),
        Route::new("/scans/{id}/frames/{step}/depth.png").on(
            Method::Get,
            Doc::new("The depth of a step, from 1, in colours", png()),
            depth,
        ),
        Route::new("/scans/{id}/frames/{step}/color.png").on(
            Method::Get,
            Doc::new("The colours of a step, from 1", png()),
            color,
        ),
    ]
}

async fn get_scene(
    State(app): State<Arc<App>>,
    Path(id): Path<String>,
    Query(SceneQuery { after }): Query<SceneQuery>,
) -> Result<Response, Refusal> {
    let scan = app.scans.find(&id)?;
    let copy = |work: &mut Work| {
        let is_paused = work.is_finished() || work.about.is_paused;
        let scan = work.shown()?;
        let next = if is_paused { None } else { scan.next()? };
        Ok(SceneSource::of_scan(scan.scan(), scan.config(), next))
    };
    let scene = scan.scene(copy, after).await?;
    Ok(([(header::CONTENT_TYPE, "application/json")], scene).into_response())
}

async fn depth(app: State<Arc<App>>, path: Path<(String, usize)>) -> Result<Response, Refusal> {
    picture(app, path, |scan, step_idx| Ok(depth_png(scan.scan().frame(step_idx)?.image()))).await
}

async fn color(app: State<Arc<App>>, path: Path<(String, usize)>) -> Result<Response, Refusal> {
    let png = |scan: &LiveScan, step_idx| {
        let color = scan.scan().color(step_idx)?;
        let none = || Refusal::of(StatusCode::NOT_FOUND, "the frame of this step came without colours");
        Ok(color_png(&color.ok_or_else(none)?))
    };
    picture(app, path, png).await
}

/// A picture of the step with this index from 0, as PNG.
async fn picture(
    State(app): State<Arc<App>>,
    Path((id, step)): Path<(String, usize)>,
    png: impl FnOnce(&LiveScan, usize) -> Result<Vec<u8>, Refusal> + Send + 'static,
) -> Result<Response, Refusal> {
    let scan = app.scans.find(&id)?;
    let png = scan.with(move |work| {
        let scan = work.shown()?;
        png(scan, step_idx(scan, step)?)
    });
    Ok(([(header::CONTENT_TYPE, "image/png")], png.await?).into_response())
}

fn step_idx(scan: &LiveScan, step: usize) -> Result<usize, Refusal> {
    let n = scan.scan().steps.len();
    step.checked_sub(1).filter(|step_idx| *step_idx < n).ok_or_else(|| {
        let fault = Fault::of_value("step", step, format!("1 to {n}, the frames so far"));
        Refusal::new(StatusCode::NOT_FOUND, fault)
    })
}
