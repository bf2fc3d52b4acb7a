//! Frames in requests.

mod head;
mod multipart;
mod posted;
mod query;

pub(crate) use head::FrameHead;
pub(crate) use posted::PostedFrame;
pub(crate) use query::FrameQuery;

use crate::app::App;
use crate::body::{Received, is_kind, receive, wrong_kind};
use crate::refusal::Refusal;
use crate::room::Share;
use axum::body::Body;
use axum::http::{HeaderMap, header};
use posted::DepthBytes;

/// Receives a frame in the format of its content type, with its share of the memory for bodies.
pub(crate) async fn receive_frame(
    app: &App,
    headers: &HeaderMap,
    query: FrameQuery,
    body: Body,
) -> Result<(PostedFrame, Share), Refusal> {
    let kind = headers.get(header::CONTENT_TYPE).map(|kind| kind.as_bytes());
    let is = |expected| kind.is_some_and(|kind| is_kind(kind, expected));
    if is("multipart/form-data") {
        let Received { bytes, share } = receive(app, headers, body).await?;
        return Ok((multipart::read(headers, bytes).await?, share));
    }
    if is("image/png") {
        let head = query.head()?;
        let Received { bytes, share } = receive(app, headers, body).await?;
        return Ok((PostedFrame::of_depth(head, DepthBytes::Png(bytes)), share));
    }
    if is("application/octet-stream") {
        let (head, shape) = (query.head()?, query.shape()?);
        let Received { bytes, share } = receive(app, headers, body).await?;
        return Ok((PostedFrame::of_depth(head, DepthBytes::Raw(shape, bytes)), share));
    }
    Err(wrong_kind(kind, "multipart/form-data, image/png or application/octet-stream"))
}
