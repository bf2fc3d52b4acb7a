use super::head::FrameHead;
use super::posted::{DepthBytes, PostedFrame};
use crate::json::json;
use crate::refusal::Refusal;
use axum::body::Body;
use axum::extract::{FromRequest, Multipart};
use axum::http::{HeaderMap, Request, StatusCode, header};
use nextview_scan::Fault;

/// The parts of a frame's body, each at most once.
#[derive(Default)]
struct Parts {
    frame: Option<Vec<u8>>,
    depth: Option<Vec<u8>>,
    color: Option<Vec<u8>>,
    mask: Option<Vec<u8>>,
}

/// Reads a multipart frame: `frame`, JSON; `depth`, a PNG; optional `color` and `mask`.
pub(super) async fn read(headers: &HeaderMap, bytes: Vec<u8>) -> Result<PostedFrame, Refusal> {
    let parts = parts(headers, bytes).await?;
    let frame = parts.frame.ok_or_else(|| missing("frame", "JSON with `id` and `world_from_camera`"))?;
    let depth = parts.depth.ok_or_else(|| missing("depth", "a PNG image of 16 bits a pixel"))?;
    let head: FrameHead = json(&frame, "`frame`")?;
    Ok(PostedFrame { head, depth: DepthBytes::Png(depth), color: parts.color, mask: parts.mask })
}

async fn parts(headers: &HeaderMap, bytes: Vec<u8>) -> Result<Parts, Refusal> {
    let mut request = Request::new(Body::from(bytes));
    let kind = headers.get(header::CONTENT_TYPE).cloned();
    kind.map(|kind| request.headers_mut().insert(header::CONTENT_TYPE, kind));
    // The body was received within the server's limit.
    let broken =
        |error: &dyn std::fmt::Display| Refusal::of(StatusCode::BAD_REQUEST, format!("the parts: {error}"));
    let mut request = request;
    axum::extract::DefaultBodyLimit::apply(axum::extract::DefaultBodyLimit::disable(), &mut request);
    let mut form = Multipart::from_request(request, &()).await.map_err(|error| broken(&error))?;
    let mut parts = Parts::default();
    while let Some(field) = form.next_field().await.map_err(|error| broken(&error))? {
        let name = field.name().unwrap_or_default().to_owned();
        let part = match &*name {
            "frame" => &mut parts.frame,
            "depth" => &mut parts.depth,
            "color" => &mut parts.color,
            "mask" => &mut parts.mask,
            _ => {
                let name: String = name.chars().take(80).collect();
                return Err(Refusal::content(Fault::of_value("part", name, "frame, depth, color or mask")));
            }
        };
        if part.is_some() {
            return Err(Refusal::content(Fault::of_value("part", name, "each part at most once")));
        }
        *part = Some(field.bytes().await.map_err(|error| broken(&error))?.to_vec());
    }
    Ok(parts)
}

fn missing(part: &str, expected: &str) -> Refusal {
    Refusal::content(Fault::of_value(part, "missing", expected))
}
