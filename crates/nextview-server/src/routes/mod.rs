//! The routes: a single list defines both the router and the OpenAPI document.

mod control;
mod events;
mod exports;
mod files;
mod frames;
mod guidance;
mod next;
mod pictures;
mod route;
mod scans;
mod statics;

pub(crate) use route::{Content, Doc, Operation, Route};

use crate::app::App;
use crate::guard::guard;
use crate::refusal::Refusal;
use axum::Router;
use axum::extract::Request;
use axum::http::{StatusCode, Uri, header};
use axum::middleware::{Next, from_fn, from_fn_with_state};
use axum::response::{IntoResponse, Response};
use std::sync::Arc;

/// All routes.
pub(crate) fn routes() -> Vec<Route> {
    let groups = [
        statics::routes(),
        scans::routes(),
        frames::routes(),
        next::routes(),
        guidance::routes(),
        control::routes(),
        files::routes(),
        exports::routes(),
        pictures::routes(),
        events::routes(),
    ];
    groups.into_iter().flatten().collect()
}

/// The service of all routes behind access control.
pub(crate) fn service(app: Arc<App>) -> Router {
    let add = |router: Router<Arc<App>>, route: Route| router.route(route.path, route.handlers);
    let router = routes().into_iter().fold(Router::new(), add);
    let router = router.fallback(unknown).method_not_allowed_fallback(wrong_method);
    let guarded = router.layer(from_fn(explain)).layer(from_fn_with_state(app.clone(), guard));
    guarded.with_state(app)
}

/// Converts plain-text refusals of the library to the form of all others.
async fn explain(request: Request, next: Next) -> Response {
    let response = next.run(request).await;
    let (status, headers) = (response.status(), response.headers());
    let is_refusal = status.is_client_error() || status.is_server_error();
    if !is_refusal || headers.get(header::CONTENT_TYPE).is_some_and(|kind| kind == "application/json") {
        return response;
    }
    let text = axum::body::to_bytes(response.into_body(), 1 << 12).await.unwrap_or_default();
    Refusal::of(status, String::from_utf8_lossy(&text)).into_response()
}

async fn unknown(uri: Uri) -> Refusal {
    let path: String = uri.path().chars().take(200).collect();
    let fault = nextview_scan::Fault::of_value("path", path, "a route of this server");
    Refusal::new(StatusCode::NOT_FOUND, fault.with_remedy("`GET /openapi.json` lists all"))
}

async fn wrong_method(method: axum::http::Method, uri: Uri) -> Refusal {
    let path: String = uri.path().chars().take(200).collect();
    let fault = nextview_scan::Fault::of_value("method", method, format!("a method that {path} has"));
    Refusal::new(StatusCode::METHOD_NOT_ALLOWED, fault.with_remedy("`GET /openapi.json` lists all"))
}
