use crate::access::{Access, Hosts, Token};
use crate::app::App;
use crate::connections;
use crate::openapi::openapi;
use crate::room::BodyRoom;
use crate::scans::{Scans, ScansFolder};
use crate::{Limits, routes};
use nextview_scan::{Fault, Faults};
use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;
use tokio::net::TcpListener;
use tokio::sync::{Semaphore, watch};

/// Configuration of a server.
#[derive(Clone, Debug)]
pub struct ServerConfig {
    /// Address to listen on; port 0 takes any free one. Default 127.0.0.1:7878.
    pub listen: SocketAddr,
    /// Additional names under which clients reach it, without port; its address and `localhost` are included.
    pub hosts: Vec<String>,
    /// The folder of all scans, each in a folder named by its id. Default `nextview-scans`.
    pub dir: PathBuf,
    /// The token required from clients other than its page; `None` for no token, which is allowed on loopback
    /// only.
    pub token: Option<String>,
    /// Limits of the server.
    pub limits: Limits,
}

impl Default for ServerConfig {
    fn default() -> Self {
        Self {
            listen: SocketAddr::from(([127, 0, 0, 1], 7878)),
            hosts: Vec::new(),
            dir: "nextview-scans".into(),
            token: None,
            limits: Limits::default(),
        }
    }
}

/// A running server.
#[derive(Clone, Debug)]
pub struct Started {
    /// Address that it listens on.
    pub address: SocketAddr,
    /// URL of the page, with its token, which permits everything.
    pub page: String,
    /// Number of interrupted scans being resumed.
    pub n_resumed: usize,
    /// The faults of unreadable scans in the folder: they are not listed, and their files are not touched.
    pub left_out: Vec<Faults>,
}

/// Idle time before a thread for long work ends.
const THREADS_STAY: Duration = Duration::from_secs(365 * 24 * 3600);

/// Serves until the process is asked to end (Ctrl-C, or SIGTERM); then answers running requests and returns.
///
/// ```no_run
/// use nextview_server::{ServerConfig, serve};
///
/// serve(ServerConfig::default(), |started| println!("page: {}", started.page))?;
/// # Ok::<(), nextview_scan::Faults>(())
/// ```
///
/// # Errors
/// If it cannot listen there, or the folder cannot be read and written; if another server serves the folder,
/// or it is inside a scan's folder; if a non-loopback address is requested without a token.
pub fn serve(config: ServerConfig, on_started: impl FnOnce(&Started)) -> Result<(), Faults> {
    let ServerConfig { listen, hosts, dir, token, limits } = config;
    let clients = token.map(|token| Token::chosen(&token)).transpose()?;
    if clients.is_none() && !listen.ip().is_loopback() {
        let fault =
            Fault::of_value("listen", listen, "a loopback address, such as 127.0.0.1:7878, or a token");
        let remedy = "state a `token_file`, or the token in the environment variable NEXTVIEW_TOKEN";
        return Err(fault.with_remedy(remedy).into());
    }
    let page = Token::random()?;
    // Both before touching the folder: it may belong to another server.
    let listener = std::net::TcpListener::bind(listen).map_err(|error| {
        Fault::data(format!("cannot listen on {listen}: {error}"))
            .with_remedy("set `listen` to another address")
    })?;
    listener.set_nonblocking(true)?;
    let folder = ScansFolder::take(&dir)?;
    let (scans, left_out) = Scans::open(folder, limits)?;
    let runtime =
        tokio::runtime::Builder::new_multi_thread().enable_all().thread_keep_alive(THREADS_STAY).build()?;
    runtime.block_on(async {
        // Keeps one thread for long work: if the system allows no more threads, work waits for it instead of
        // failing.
        _ = tokio::task::spawn_blocking(|| ()).await;
        let listener = TcpListener::from_std(listener)?;
        let address = listener.local_addr()?;
        let n_resumed = scans.n_interrupted();
        let started = Started { address, page: page_address(address, &page), n_resumed, left_out };
        let (close, is_closing) = watch::channel(false);
        let app = Arc::new(App {
            limits,
            access: Access { hosts: Hosts::new(address, hosts), page, clients },
            openapi: openapi(),
            scans: Arc::new(scans),
            bodies: Arc::new(BodyRoom::new(limits.all_bodies_bytes)),
            streams: Arc::new(Semaphore::new(limits.event_streams)),
            is_closing,
        });
        on_started(&started);
        let resuming = app.clone();
        tokio::spawn(async move { resuming.scans.resume_all().await });
        connections::accept(listener, routes::service(app), limits, asked_to_end(), close).await;
        Ok(())
    })
}

/// The URL of the page for a browser on this machine.
fn page_address(address: SocketAddr, token: &Token) -> String {
    let address = match address.ip().is_unspecified() {
        true => SocketAddr::from(([127, 0, 0, 1], address.port())),
        false => address,
    };
    format!("http://{address}/#token={}", token.reveal())
}

/// Returns when the process is asked to end.
async fn asked_to_end() {
    #[cfg(unix)]
    {
        use tokio::signal::unix::{SignalKind, signal};
        if let Ok(mut terminate) = signal(SignalKind::terminate()) {
            tokio::select! {
                _ = tokio::signal::ctrl_c() => (),
                _ = terminate.recv() => (),
            }
            return;
        }
    }
    let _ = tokio::signal::ctrl_c().await;
}
