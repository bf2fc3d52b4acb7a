//! A server without sockets, for `fuzz/` only.

use crate::Limits;
use crate::access::{Access, Hosts, Token};
use crate::app::App;
use crate::room::BodyRoom;
use crate::routes;
use crate::scans::{NewScan, Scans, ScansFolder};
use axum::Router;
use hyper::server::conn::http1;
use hyper_util::rt::TokioIo;
use hyper_util::service::TowerToHyperService;
use std::net::SocketAddr;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::runtime::Runtime;
use tokio::sync::{Semaphore, watch};

/// Parses the description of a scan.
pub fn new_scan(bytes: &[u8]) {
    let _ = NewScan::from_json(bytes).and_then(|new| new.config(None, &Limits::default()));
}

/// A server for small scans.
pub struct Server {
    runtime: Runtime,
    app: Arc<App>,
    router: Router,
    /// Never signalled.
    _close: watch::Sender<bool>,
}

/// Maximum length of an answer to read, in bytes: a stream of events has no end.
const MOST: u64 = 1 << 20;

impl Server {
    /// Starts a server with its scans in this folder.
    pub fn new(dir: &Path) -> Self {
        let limits = Limits {
            body_bytes: 1 << 16,
            all_bodies_bytes: 1 << 20,
            image_pixels: 64,
            scans: 2,
            frames: 3,
            candidates: 20,
            free_disk_mb: 0,
            ..Limits::default()
        };
        let folder = ScansFolder::take(dir).expect("the folder can be written");
        let (close, is_closing) = watch::channel(false);
        let app = Arc::new(App {
            limits,
            access: Access {
                hosts: Hosts::new(SocketAddr::from(([127, 0, 0, 1], 80)), Vec::new()),
                page: Token::random().expect("the system has random numbers"),
                clients: None,
            },
            openapi: serde_json::Value::Null,
            scans: Arc::new(Scans::open(folder, limits).expect("the folder can be read").0),
            bodies: Arc::new(BodyRoom::new(limits.all_bodies_bytes)),
            streams: Arc::new(Semaphore::new(limits.event_streams)),
            is_closing,
        });
        let runtime =
            tokio::runtime::Builder::new_current_thread().enable_all().build().expect("there are threads");
        Self { runtime, router: routes::service(app.clone()), app, _close: close }
    }

    /// Sends these bytes unchanged on a connection, reads the answers, and removes all scans.
    pub fn send(&self, bytes: &[u8]) {
        self.runtime.block_on(async {
            self.exchange(bytes).await;
            let ids: Vec<String> = self.app.scans.list().into_iter().map(|scan| scan.id).collect();
            for id in ids {
                self.exchange(
                    format!("DELETE /scans/{id} HTTP/1.1\r\nhost: 127.0.0.1:80\r\n\r\n").as_bytes(),
                )
                .await;
            }
        });
    }

    async fn exchange(&self, bytes: &[u8]) {
        let (mut client, server) = tokio::io::duplex(1 << 16);
        let service = TowerToHyperService::new(self.router.clone());
        let serve = http1::Builder::new().serve_connection(TokioIo::new(server), service);
        let ask = async {
            let _ = client.write_all(bytes).await;
            let _ = client.shutdown().await;
            let mut answers = Vec::new();
            let mut rest = client.take(MOST);
            let _ = tokio::time::timeout(Duration::from_secs(2), rest.read_to_end(&mut answers)).await;
        };
        let _ = tokio::join!(serve, ask);
    }
}
