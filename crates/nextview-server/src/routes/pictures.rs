use super::route::{Content, Doc, Method, Route};
use crate::app::App;
use crate::refusal::Refusal;
use crate::scans::{PageContent, Picture, Work, kept_page};
use axum::extract::{Path, Query, State};
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use nextview_report::live::SceneSource;
use nextview_scan::Fault;
use schemars::JsonSchema;
use serde::Deserialize;
use std::sync::Arc;

/// The part of a scene.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct SceneQuery {
    /// Number of frames that the page already has. Default 0.
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
    let shown = |work: &mut Work| {
        if work.is_finished() {
            return Ok(PageContent::Finished(kept_page::scene(work.dir())?));
        }
        let next = if work.about.is_paused { None } else { work.next_view()? };
        let (scan, _) = work.under_way()?;
        Ok(PageContent::UnderWay(Box::new(SceneSource::of_scan(scan.scan(), scan.config(), next))))
    };
    let scene = scan.scene(shown, after).await?;
    Ok(([(header::CONTENT_TYPE, "application/json")], scene).into_response())
}

async fn depth(app: State<Arc<App>>, path: Path<(String, usize)>) -> Result<Response, Refusal> {
    get(app, path, Picture::Depth).await
}

async fn color(app: State<Arc<App>>, path: Path<(String, usize)>) -> Result<Response, Refusal> {
    get(app, path, Picture::Color).await
}

async fn get(
    State(app): State<Arc<App>>,
    Path((id, step)): Path<(String, usize)>,
    picture: Picture,
) -> Result<Response, Refusal> {
    let scan = app.scans.find(&id)?;
    let png = scan.with(move |work| {
        let png = if work.is_finished() {
            picture.of_folder(work.dir(), step_idx(work, step)?)?
        } else {
            work.under_way()?;
            let step_idx = step_idx(work, step)?;
            picture.of_scan(work.under_way()?.0, step_idx)?
        };
        png.ok_or_else(|| Refusal::of(StatusCode::NOT_FOUND, "the frame of this step has no colours"))
    });
    Ok(([(header::CONTENT_TYPE, "image/png")], png.await?).into_response())
}

fn step_idx(work: &Work, step: usize) -> Result<usize, Refusal> {
    let n = work.n_frames().unwrap_or(0);
    step.checked_sub(1).filter(|step_idx| *step_idx < n).ok_or_else(|| {
        let fault = Fault::of_value("step", step, format!("1 to {n}, the frames so far"));
        Refusal::new(StatusCode::NOT_FOUND, fault)
    })
}
