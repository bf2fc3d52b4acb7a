//! A server in a separate process: this program again, with another task.

use crate::client::Client;
use nextview_server::{Limits, ServerConfig, serve};
use std::fs;
use std::io::{BufRead, BufReader};
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

/// The environment variables that tell the process what to do.
const DIR: &str = "NEXTVIEW_TEST_SERVER_DIR";
const TIGHT: &str = "NEXTVIEW_TEST_SERVER_TIGHT";
const FULL: &str = "NEXTVIEW_TEST_SERVER_FULL";
const TOKEN: &str = "NEXTVIEW_TEST_SERVER_TOKEN";

/// Not a test: the task of a process of [`Server`].
#[test]
fn is_a_server() {
    let Some(dir) = std::env::var_os(DIR) else { return };
    let tight = Limits {
        body_bytes: 1 << 20,
        all_bodies_bytes: 8 << 20,
        scans: 6,
        frames: 40,
        connections: 40,
        event_streams: 4,
        queue: 4,
        head_time: Duration::from_millis(500),
        body_time: Duration::from_millis(500),
        ..Limits::default()
    };
    let limits = if std::env::var_os(TIGHT).is_some() { tight } else { Limits::default() };
    let limits = match std::env::var(FULL).as_deref() {
        Ok("disk") => Limits { free_disk_mb: u64::MAX, ..limits },
        Ok("memory") => Limits { free_disk_mb: 1, memory_mb: 0, ..limits },
        _ => Limits { free_disk_mb: 1, ..limits },
    };
    let listen = SocketAddr::from(([127, 0, 0, 1], 0));
    let token = std::env::var(TOKEN).ok();
    let config = ServerConfig { listen, dir: dir.into(), limits, token, ..ServerConfig::default() };
    let served = serve(config, |started| println!("\nADDRESS {}\nTOKEN {}", started.address, started.page));
    if let Err(faults) = served {
        println!("\nREFUSED {faults}");
    }
}

/// A running server, killed at the end.
pub struct Server {
    child: Child,
    pub address: SocketAddr,
    /// Token of the page.
    pub token: String,
}

impl Server {
    pub fn start(dir: &Path) -> Self {
        Self::with(dir, &[])
    }

    /// Starts a server with low limits.
    pub fn tight(dir: &Path) -> Self {
        Self::with(dir, &[(TIGHT, "1")])
    }

    /// Starts a server that considers its `disk` or its `memory` full.
    pub fn full(dir: &Path, what: &str) -> Self {
        Self::with(dir, &[(FULL, what)])
    }

    /// Starts a server that requires this token from every client.
    pub fn with_token(dir: &Path, token: &str) -> Self {
        Self::with(dir, &[(TOKEN, token)])
    }

    fn with(dir: &Path, environment: &[(&str, &str)]) -> Self {
        Self::spawned(dir, environment).unwrap_or_else(|said| panic!("the server does not start: {said}"))
    }

    /// Starts a server that must fail to start; returns its message.
    pub fn refused(dir: &Path) -> String {
        Self::spawned(dir, &[]).map(drop).unwrap_err()
    }

    fn spawned(dir: &Path, environment: &[(&str, &str)]) -> Result<Self, String> {
        let mut command = Command::new(std::env::current_exe().unwrap());
        command.args(["--exact", "process::is_a_server", "--nocapture"]).env(DIR, dir);
        command.envs(environment.iter().copied()).stdout(Stdio::piped());
        let mut child = command.spawn().unwrap();
        let mut lines = BufReader::new(child.stdout.take().unwrap()).lines().map_while(Result::ok);
        let mut value = |name: &str| {
            let said = lines.find_map(|line| {
                let refused = line.strip_prefix("REFUSED ").map(|why| Err(why.to_owned()));
                refused.or_else(|| line.strip_prefix(name).map(|value| Ok(value.to_owned())))
            });
            said.unwrap_or_else(|| panic!("the server said no {name}"))
        };
        let said = value("ADDRESS ").and_then(|address| Ok((address, value("TOKEN ")?)));
        let (address, token) = match said {
            Ok((address, page)) => {
                (address.parse().unwrap(), page.rsplit_once("#token=").unwrap().1.to_owned())
            }
            Err(why) => {
                child.wait().unwrap();
                return Err(why);
            }
        };
        // Nothing more is needed from its output, but a closed pipe would be an error for the server.
        std::thread::spawn(move || lines.for_each(drop));
        Ok(Self { child, address, token })
    }

    pub fn client(&self) -> Client {
        Client::new(self.address)
    }

    /// As `kill -9`.
    pub fn kill(&mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }

    /// Ends the server as Ctrl-C does; returns whether it succeeded.
    #[cfg(unix)]
    pub fn end(mut self) -> bool {
        let id = self.child.id().to_string();
        assert!(Command::new("kill").args(["-TERM", &id]).status().unwrap().success());
        self.child.wait().unwrap().success()
    }

    /// Peak memory of the server in MB.
    pub fn peak_mb(&self) -> Option<f64> {
        let status = fs::read_to_string(format!("/proc/{}/status", self.child.id())).ok()?;
        let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
        Some(line.trim().trim_end_matches("kB").trim().parse::<f64>().ok()? / 1024.0)
    }

    pub fn is_running(&mut self) -> bool {
        self.child.try_wait().unwrap().is_none()
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// A fresh folder, removed at the end unless the test fails.
pub struct Folder(PathBuf);

impl Folder {
    /// The name must differ from those of all other tests of this crate.
    pub fn new(name: &str) -> Self {
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(env!("CARGO_PKG_NAME")).join(name);
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        if !std::thread::panicking() {
            let _ = fs::remove_dir_all(&self.0);
        }
    }
}

/// A number of repetitions that an environment variable may raise.
pub fn n_from_env(name: &str, default: usize) -> usize {
    std::env::var(name).map_or(default, |n| n.parse().unwrap())
}
