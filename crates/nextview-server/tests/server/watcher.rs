//! An open page, as the server sees it: it listens to events, and requests the scene and the view at each.

use crate::client::Client;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Duration;

/// An open page of a scan.
#[derive(Default)]
pub struct Watcher {
    is_stale: AtomicBool,
    is_over: AtomicBool,
    /// Bytes of all scenes.
    pub n_bytes: AtomicUsize,
    /// Number of scenes.
    pub n_scenes: AtomicUsize,
}

impl Watcher {
    /// Shows the scan until it is over. As in a browser, events while a scene is loading cause one more
    /// request.
    pub fn watch(&self, id: &str, mut events: Client, mut client: Client) {
        std::thread::scope(|scope| {
            scope.spawn(move || self.listen(id, &mut events));
            let mut n_views = 0;
            while !self.is_over.load(Ordering::SeqCst) || self.is_stale.load(Ordering::SeqCst) {
                if !self.is_stale.swap(false, Ordering::SeqCst) {
                    std::thread::sleep(Duration::from_millis(1));
                    continue;
                }
                let scene = client.get(&format!("/scans/{id}/scene?after={n_views}"));
                self.n_bytes.fetch_add(scene.body.len(), Ordering::SeqCst);
                self.n_scenes.fetch_add(1, Ordering::SeqCst);
                n_views = scene.expect(200)["n_views"].as_u64().unwrap();
                client.get(&format!("/scans/{id}/next")).expect(200);
            }
        });
    }

    fn listen(&self, id: &str, events: &mut Client) {
        let head = format!("GET /scans/{id}/events HTTP/1.1\r\nhost: {}\r\n\r\n", events.host());
        events.write(head.as_bytes()).unwrap();
        loop {
            match events.line().unwrap().strip_prefix("event: ") {
                Some("finished") => return self.is_over.store(true, Ordering::SeqCst),
                Some(_) => self.is_stale.store(true, Ordering::SeqCst),
                None => (),
            }
        }
    }
}
