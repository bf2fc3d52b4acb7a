//! Request bodies of bounded size and time.

use crate::app::App;
use crate::json::json;
use crate::limits::exceeded;
use crate::refusal::Refusal;
use crate::room::Share;
use axum::body::Body;
use axum::http::{HeaderMap, StatusCode, header};
use futures_util::StreamExt;
use nextview_scan::Fault;
use serde::de::DeserializeOwned;

/// A body with its share of the memory for bodies; hold it as long as the bytes.
pub(crate) struct Received {
    pub bytes: Vec<u8>,
    pub share: Share,
}

/// Receives a complete body.
pub(crate) async fn receive(app: &App, headers: &HeaderMap, body: Body) -> Result<Received, Refusal> {
    let most = app.limits.body_bytes;
    let stated = headers.get(header::CONTENT_LENGTH).and_then(|length| length.to_str().ok()?.parse().ok());
    if let Some(stated) = stated.filter(|stated| *stated > most) {
        return Err(too_large(stated, most));
    }
    let (share, gives_way) = app.bodies.begin();
    let received = async {
        tokio::select! {
            received = collect(body, share, most) => received,
            _ = gives_way => Err(no_room()),
        }
    };
    tokio::time::timeout(app.limits.body_time, received).await.map_err(|_| {
        let seconds = app.limits.body_time.as_secs();
        Refusal::of(StatusCode::REQUEST_TIMEOUT, format!("the body did not arrive within {seconds} s"))
    })?
}

/// Memory is reserved as bytes arrive, not as they are announced.
async fn collect(body: Body, mut share: Share, most: usize) -> Result<Received, Refusal> {
    let mut bytes = Vec::new();
    let mut parts = body.into_data_stream();
    while let Some(part) = parts.next().await {
        let part = part.map_err(|error| {
            Refusal::of(StatusCode::BAD_REQUEST, format!("the body ended early or is malformed: {error}"))
        })?;
        if bytes.len() + part.len() > most {
            return Err(too_large(bytes.len() + part.len(), most));
        }
        if !share.grow(part.len()) {
            return Err(no_room());
        }
        bytes.extend_from_slice(&part);
    }
    match share.complete() {
        true => Ok(Received { bytes, share }),
        false => Err(no_room()),
    }
}

fn no_room() -> Refusal {
    let fault = Fault::request("the server is already receiving as many large bodies as it has room for");
    Refusal::busy(StatusCode::SERVICE_UNAVAILABLE, fault)
}

fn too_large(value: usize, most: usize) -> Refusal {
    let fault = exceeded("content-length", value, format!("{most} bytes"));
    Refusal::new(StatusCode::PAYLOAD_TOO_LARGE, fault)
}

/// Receives a JSON body; `what` names it in messages.
pub(crate) async fn receive_json<T: DeserializeOwned>(
    app: &App,
    headers: &HeaderMap,
    body: Body,
    what: &str,
) -> Result<T, Refusal> {
    let kind = headers.get(header::CONTENT_TYPE).map(|kind| kind.as_bytes());
    if kind.is_some_and(|kind| !is_kind(kind, "application/json")) {
        return Err(wrong_kind(kind, "application/json"));
    }
    json(&receive(app, headers, body).await?.bytes, what)
}

/// Whether a content type is this one, ignoring parameters.
pub(crate) fn is_kind(kind: &[u8], expected: &str) -> bool {
    let bare = kind.split(|byte| *byte == b';').next().unwrap_or_default();
    bare.trim_ascii().eq_ignore_ascii_case(expected.as_bytes())
}

/// Refuses an unsupported content type.
pub(crate) fn wrong_kind(kind: Option<&[u8]>, expected: &str) -> Refusal {
    let kind = kind.map_or("missing".into(), String::from_utf8_lossy);
    Refusal::new(StatusCode::UNSUPPORTED_MEDIA_TYPE, Fault::of_value("content-type", kind, expected))
}
