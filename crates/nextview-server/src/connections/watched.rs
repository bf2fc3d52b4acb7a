use super::places::{ActingSide, HeldPlace};
use hyper::body::{Body, Frame, SizeHint};
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};

/// A body that records whose turn it is: the client's while more of a request's body is awaited, and after
/// the end of an answer's body.
pub(super) struct Watched<B> {
    inner: B,
    place: Arc<HeldPlace>,
    /// The turns while the body is awaited, and after its end.
    turns: (ActingSide, ActingSide),
}

impl<B> Watched<B> {
    pub fn request(inner: B, place: Arc<HeldPlace>) -> Self {
        Self { inner, place, turns: (ActingSide::Body, ActingSide::Server) }
    }

    pub fn answer(inner: B, place: Arc<HeldPlace>) -> Self {
        Self { inner, place, turns: (ActingSide::Server, ActingSide::Head) }
    }
}

impl<B: Body + Unpin> Body for Watched<B> {
    type Data = B::Data;
    type Error = B::Error;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<B::Data>, B::Error>>> {
        let polled = Pin::new(&mut self.inner).poll_frame(context);
        match polled {
            Poll::Pending => self.place.turn(self.turns.0),
            Poll::Ready(None) => self.place.turn(self.turns.1),
            // The wait for the rest begins anew.
            Poll::Ready(Some(_)) => self.place.turn(ActingSide::Server),
        }
        polled
    }

    fn is_end_stream(&self) -> bool {
        self.inner.is_end_stream()
    }

    fn size_hint(&self) -> SizeHint {
        self.inner.size_hint()
    }
}

impl<B> Drop for Watched<B> {
    /// The body was abandoned, like that of a refused request.
    fn drop(&mut self) {
        self.place.turn(self.turns.1);
    }
}
