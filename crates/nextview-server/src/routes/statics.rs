use super::route::{Content, Doc, Method, Route};
use crate::answers::Health;
use crate::app::App;
use axum::Json;
use axum::extract::State;
use axum::http::header;
use axum::response::{Html, IntoResponse};
use nextview_report::live;
use std::sync::Arc;

pub(super) fn routes() -> Vec<Route> {
    let html = || Content::of("text/html");
    vec![
        Route::new("/").on(Method::Get, Doc::new("The page of all scans", html()), page),
        Route::new("/scans/{id}/page").on(Method::Get, Doc::new("The page of a scan", html()), page),
        Route::new("/assets/viewer.js").on(
            Method::Get,
            Doc::new("The page's script", Content::of("text/javascript")),
            script,
        ),
        Route::new("/assets/style.css").on(
            Method::Get,
            Doc::new("The page's style", Content::of("text/css")),
            style,
        ),
        Route::new("/healthz").on(
            Method::Get,
            Doc::new("Whether the server runs", Content::json::<Health>()),
            health,
        ),
        Route::new("/openapi.json").on(
            Method::Get,
            Doc::new("This description", Content::json::<serde_json::Value>()),
            description,
        ),
    ]
}

async fn page() -> Html<&'static str> {
    Html(live::PAGE)
}

async fn script() -> impl IntoResponse {
    ([(header::CONTENT_TYPE, "text/javascript; charset=utf-8")], live::SCRIPT)
}

async fn style() -> impl IntoResponse {
    ([(header::CONTENT_TYPE, "text/css; charset=utf-8")], live::STYLE)
}

async fn health() -> Json<Health> {
    Json(Health { status: "ok", version: env!("CARGO_PKG_VERSION") })
}

async fn description(State(app): State<Arc<App>>) -> Json<serde_json::Value> {
    Json(app.openapi.clone())
}
