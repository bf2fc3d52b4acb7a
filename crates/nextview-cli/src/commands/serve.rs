use crate::{Failure, flags, stdout};
use clap::Args;
use nextview_scan::{Fault, Faults, files};
use nextview_server::{Limits, ServerConfig, Started, serve};
use std::net::SocketAddr;
use std::path::PathBuf;

/// Maximum size of a token file in bytes.
const MAX_TOKEN: u64 = 4096;

/// Serve scans over HTTP: post the frames of any camera, get the next view.
///
/// Every frame is saved to disk before it is acknowledged, and a server that was killed resumes all scans.
/// docs/server.md and /openapi.json describe the routes.
///
/// Any program on this machine may send requests, but web pages may not: the server's own page needs the
/// token that is printed. If other machines can reach the address, all clients need a token.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct ServeArgs {
    /// Address to listen on; port 0 picks a free port
    #[arg(long, value_name = "ADDRESS:PORT", default_value = "127.0.0.1:7878")]
    listen: SocketAddr,
    /// Folder of all scans
    #[arg(long, value_name = "DIR", default_value = "nextview-scans")]
    dir: PathBuf,
    /// File with the token that clients must send, at least 16 characters [default: the environment variable
    /// NEXTVIEW_TOKEN]
    #[arg(long, value_name = "FILE")]
    token_file: Option<PathBuf>,
    /// Another host name under which clients reach the server, without port; can be given several times
    #[arg(long = "host", value_name = "NAME")]
    hosts: Vec<String>,
    /// Maximum size of a request body
    #[arg(long, value_name = "MB", default_value = "64", value_parser = clap::value_parser!(u32).range(1..=1024))]
    max_body_mb: u32,
    /// Maximum number of pixels of an image
    #[arg(long, value_name = "N", default_value = "8000000", value_parser = clap::value_parser!(u32).range(1..))]
    max_pixels: u32,
    /// Maximum number of unfinished scans
    #[arg(long, value_name = "N", default_value = "64", value_parser = clap::value_parser!(u32).range(1..))]
    max_scans: u32,
    /// Maximum number of frames of a scan
    #[arg(long, value_name = "N", default_value = "500", value_parser = clap::value_parser!(u32).range(1..))]
    max_frames: u32,
    /// Maximum number of connections
    #[arg(long, value_name = "N", default_value = "256", value_parser = clap::value_parser!(u32).range(1..=65536))]
    max_connections: u32,
    /// Memory of the process above which new scans and frames are refused
    #[arg(long, value_name = "MB", default_value = "4096", value_parser = clap::value_parser!(u64).range(64..))]
    max_memory_mb: u64,
    /// Disk space that must stay free
    #[arg(long, value_name = "MB", default_value = "512")]
    min_free_disk_mb: u64,
}

const EXAMPLES: &str = "\
Examples:
  nextview serve
  nextview serve --listen 0.0.0.0:7878 --token-file token --host scanner.local
  curl http://127.0.0.1:7878/scans";

impl ServeArgs {
    pub fn run(self) -> Result<(), Failure> {
        let token = self.token()?;
        let mut printed = Ok(());
        serve(ServerConfig { token, limits: self.limits(), ..self.config() }, |started| {
            printed = tell(started);
        })?;
        printed
    }

    fn config(&self) -> ServerConfig {
        let (listen, hosts, dir) = (self.listen, self.hosts.clone(), self.dir.clone());
        ServerConfig { listen, hosts, dir, ..ServerConfig::default() }
    }

    fn limits(&self) -> Limits {
        let body_bytes = (self.max_body_mb as usize) << 20;
        Limits {
            body_bytes,
            all_bodies_bytes: 4 * body_bytes,
            image_pixels: self.max_pixels as usize,
            scans: self.max_scans as usize,
            frames: self.max_frames as usize,
            connections: self.max_connections as usize,
            event_streams: (self.max_connections as usize / 4).max(1),
            memory_mb: self.max_memory_mb,
            free_disk_mb: self.min_free_disk_mb,
            ..Limits::default()
        }
    }

    fn token(&self) -> Result<Option<String>, Failure> {
        if let Some(file) = &self.token_file {
            return Ok(Some(files::read_text(file, MAX_TOKEN)?));
        }
        match std::env::var("NEXTVIEW_TOKEN") {
            Ok(token) => Ok(Some(token)),
            Err(std::env::VarError::NotPresent) => Ok(None),
            Err(error) => Err(Fault::request(format!("NEXTVIEW_TOKEN: {error}")).into()),
        }
    }
}

fn tell(started: &Started) -> Result<(), Failure> {
    for fault in started.left_out.iter().flat_map(Faults::iter) {
        eprintln!("warning: a scan is skipped: {fault}");
        fault.remedy.iter().for_each(|remedy| eprintln!("hint: {}", flags::word(remedy)));
    }
    let resumed = match started.n_resumed {
        0 => String::new(),
        1 => "resuming 1 scan\n".to_owned(),
        n => format!("resuming {n} scans\n"),
    };
    stdout::print(format!("listening on http://{}\npage: {}\n{resumed}", started.address, started.page))
}
