//! Requests to a server, as they come on a connection: heads, routes, parts, frames.

#![no_main]

use libfuzzer_sys::fuzz_target;
use nextview_server::fuzzing::Server;
use std::path::PathBuf;
use std::sync::LazyLock;

struct Shared(Server);

static SERVER: LazyLock<Shared> = LazyLock::new(|| {
    let folder = [PathBuf::from("/dev/shm"), std::env::temp_dir()].into_iter().find(|folder| folder.is_dir());
    let folder = folder.expect("there is a folder").join(format!("nextview-fuzz-{}", std::process::id()));
    Shared(Server::new(&folder))
});

fuzz_target!(|bytes: &[u8]| SERVER.0.send(bytes));
