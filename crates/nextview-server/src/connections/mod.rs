//! Connections of bounded number; none waits for ever or keeps others out.

mod patient;
mod places;
mod watched;

use crate::Limits;
use crate::refusal::Refusal;
use axum::Router;
use axum::body::Body;
use axum::http::{Response, StatusCode};
use axum::response::IntoResponse;
use futures_util::FutureExt;
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::server::graceful::GracefulShutdown;
use nextview_scan::Fault;
use patient::Patient;
use places::{ActingSide, HeldPlace, Places};
use std::convert::Infallible;
use std::future::Future;
use std::panic::AssertUnwindSafe;
use std::sync::Arc;
use std::time::Duration;
use tokio::io::AsyncWriteExt;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::watch;
use watched::Watched;

/// The answer to connections if there is no room.
const FULL: &str = "{\"faults\":[{\"kind\":\"request\",\"message\":\"as many clients are connected as the server has \
                    room for\",\"remedy\":\"close connections, or try again in a second\"}]}";

/// Serves connections until shutdown is requested, then finishes requests in progress.
pub(crate) async fn accept(
    listener: TcpListener,
    router: Router,
    limits: Limits,
    end: impl Future<Output = ()>,
    close: watch::Sender<bool>,
) {
    let places = Places::new(limits.connections);
    let graceful = GracefulShutdown::new();
    let mut end = std::pin::pin!(end);
    loop {
        let stream = tokio::select! {
            accepted = listener.accept() => match accepted {
                Ok((stream, _)) => stream,
                // No file handle is left, for example: retry shortly.
                Err(_) => {
                    places.give_way();
                    tokio::time::sleep(Duration::from_millis(50)).await;
                    continue;
                }
            },
            () = &mut end => break,
        };
        let Some(place) = places.take() else {
            tokio::spawn(refuse(stream));
            continue;
        };
        // Sends answers without waiting for more data.
        let _ = stream.set_nodelay(true);
        let router = router.clone();
        let io = TokioIo::new(Patient::new(stream, limits.body_time, place.clone()));
        let served = place.clone();
        let service = service_fn(move |request| answer(router.clone(), request, served.clone()));
        let mut http = http1::Builder::new();
        http.timer(TokioTimer::new()).header_read_timeout(limits.head_time).max_headers(64);
        let connection = graceful.watch(http.serve_connection(io, service));
        tokio::spawn(async move {
            tokio::select! {
                // Errors of a connection are the client's concern.
                _ = connection => (),
                () = place.gives_way() => (),
            }
        });
    }
    drop(listener);
    close.send_replace(true);
    let _ = tokio::time::timeout(limits.answer_time, graceful.shutdown()).await;
}

/// A panic also gets an answer.
async fn answer(
    router: Router,
    request: hyper::Request<hyper::body::Incoming>,
    place: Arc<HeldPlace>,
) -> Result<Response<Body>, Infallible> {
    place.turn(ActingSide::Server);
    let request = request.map(|body| Body::new(Watched::request(body, place.clone())));
    use hyper::service::Service;
    let service = hyper_util::service::TowerToHyperService::new(router);
    let answered = AssertUnwindSafe(service.call(request)).catch_unwind().await;
    let response = match answered {
        Ok(Ok(response)) => response,
        Err(_) => {
            let fault = Fault::data("the server failed with an internal error")
                .with_remedy("please report it, with the request");
            Refusal::new(StatusCode::INTERNAL_SERVER_ERROR, fault).into_response()
        }
    };
    place.turn(ActingSide::Server);
    Ok(response.map(|body| Body::new(Watched::answer(body, place))))
}

async fn refuse(mut stream: TcpStream) {
    let head = format!(
        "HTTP/1.1 503 Service Unavailable\r\ncontent-type: application/json\r\nretry-after: 1\r\n\
         connection: close\r\ncontent-length: {}\r\n\r\n",
        FULL.len()
    );
    let told = async { stream.write_all(format!("{head}{FULL}").as_bytes()).await };
    let _ = tokio::time::timeout(Duration::from_secs(1), told).await;
}
