//! Clients, servers and programs that interfere with each other.

use crate::client::Client;
use crate::process::{Folder, Server};
use crate::robot::{Robot, post_raw};
use nextview::Cancel;
use nextview_scan::files::Overwrite;
use nextview_scan::{LiveScan, ScanJournal, begin_results};
use serde_json::json;
use std::fs;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

#[test]
fn a_folder_has_one_server() {
    let folder = Folder::new("one-server");
    let dir = folder.path("scans");
    let remnant = dir.join(".gone.deleted");
    let robot = Robot::new(3, 80);
    let server = Server::start(&dir);
    server.client().post("/scans", &robot.body("mug")).expect(201);
    fs::create_dir(&remnant).unwrap();
    let linked = folder.path("linked");
    #[cfg(unix)]
    std::os::unix::fs::symlink(&dir, &linked).unwrap();
    for same in [&dir, &linked, &folder.path("scans/../scans")] {
        let said = Server::refused(same);
        assert!(said.contains("is already served by another server"), "{said}");
    }
    assert!(remnant.exists(), "only the server of a folder cleans it up");
    let said = Server::refused(&dir.join("mug"));
    assert!(said.contains("is in the folder of a scan"), "{said}");
    drop(server);
    Server::start(&linked).client().get("/scans/mug").expect(200);
    assert!(!remnant.exists());
}

/// Another program scans into the server's folder, or somebody replaces the folder.
#[test]
fn what_is_not_the_servers_stays_as_it_is() {
    let folder = Folder::new("not-its-own");
    let dir = folder.path("scans");
    let robot = Robot::new(3, 80);
    let server = Server::start(&dir);
    let mut client = server.client();
    let journal = ScanJournal::begin(&dir.join("mug"), "another program's").unwrap();
    assert_eq!(client.post("/scans", &robot.body("mug")).status, 409);
    assert!(ScanJournal::is_in(&dir.join("mug")));
    drop(journal);
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("nowhere", dir.join("link")).unwrap();
        assert_eq!(client.post("/scans", &robot.body("link")).status, 409);
        fs::rename(&dir, folder.path("moved")).unwrap();
        fs::create_dir(&dir).unwrap();
        let answer = client.post("/scans", &robot.body("lost"));
        assert!(
            answer.status == 500 && answer.message().contains("moved, removed or replaced"),
            "{answer:?}"
        );
        assert_eq!(fs::read_dir(&dir).unwrap().count(), 0);
    }
}

/// Otherwise the server would replace the results and lose their frames.
#[test]
fn a_scan_that_another_process_finished_is_not_begun_again() {
    let folder = Folder::new("finished-elsewhere");
    let dir = folder.path("scans");
    let (robot, place) = (Robot::new(3, 80), dir.join("mug"));
    let mut server = Server::start(&dir);
    let mut client = server.client();
    client.post("/scans", &robot.body("mug")).expect(201);
    let rows = client.get("/scans/mug/next").expect(200)["view"]["world_from_camera"].clone();
    let frame = robot.frame(&rows, true);
    post_raw(&mut client, "mug", "a", &rows, frame.image()).expect(200);
    server.kill();
    let mut scan = LiveScan::resume(&place, Cancel::default()).unwrap();
    let server = Server::start(&dir);
    let mut client = server.client();
    let answer = client.get("/scans/mug/next");
    assert!(answer.message().contains("is in use by a running scan"), "{answer:?}");
    scan.end();
    let mut results = begin_results(&place, Overwrite::results()).unwrap();
    scan.write_results(&mut results).unwrap();
    results.publish().unwrap();
    scan.forget_journal();
    drop(scan);
    let steps = fs::read(place.join("steps.jsonl")).unwrap();
    assert_eq!(client.get("/scans/mug/next").expect(200)["state"], "finished");
    let answer = post_raw(&mut client, "mug", "b", &rows, frame.image());
    assert!(answer.status == 409 && answer.message().contains("is finished"), "{answer:?}");
    client.post("/scans/mug/finish", &json!({})).expect(200);
    assert_eq!(client.get("/scans/mug").expect(200)["n_frames"], 1);
    assert_eq!(fs::read(place.join("steps.jsonl")).unwrap(), steps);
}

/// Idle clients hold all connections and all memory for bodies.
#[test]
fn a_request_passes_beside_idle_and_slow_clients() {
    let folder = Folder::new("slow");
    let server = Server::start(&folder.path("scans"));
    let robot = Robot::new(3, 80);
    let mut client = server.client();
    client.post("/scans", &robot.body("mug")).expect(201);
    let rows = client.get("/scans/mug/next").expect(200)["view"]["world_from_camera"].clone();
    let frame = robot.frame(&rows, true);
    let post = |id: &str| {
        let start = Instant::now();
        let mut client = server.client();
        post_raw(&mut client, "mug", id, &rows, frame.image()).expect(200);
        assert!(start.elapsed() < Duration::from_secs(2), "{id}: {:?}", start.elapsed());
    };
    let host = server.address;
    let announced = format!(
        "POST /scans/mug/frames?id=x HTTP/1.1\r\nhost: {host}\r\ncontent-type: image/png\r\ncontent-length: 67108864\r\n\r\n"
    );
    let opened = |bytes: &[u8], n: usize| -> Vec<Client> {
        let client = |_| {
            let mut client = Client::new(host);
            // The server may have closed it already.
            let _ = client.write(bytes);
            client
        };
        (0..n).map(client).collect()
    };
    let _announced = opened(announced.as_bytes(), 300);
    post("announced-bodies");
    let _idle = opened(b"", 300);
    post("idle");
    let _half = opened(b"GET /scans HTT", 300);
    post("half-heads");
    let is_done = AtomicBool::new(false);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            while !is_done.load(Ordering::Relaxed) {
                drop(opened(b"", 1));
            }
        });
        (0..20).for_each(|i| post(&format!("beside-new-connections-{i}")));
        is_done.store(true, Ordering::Relaxed);
    });
    let started = [announced.as_bytes(), &vec![0; (64 << 20) - 1]].concat();
    std::thread::scope(|scope| {
        let bodies: Vec<_> = (0..6).map(|_| scope.spawn(|| opened(&started, 1))).collect();
        bodies.into_iter().for_each(|body| drop(body.join().map(|held| (post("bodies-that-stop"), held))));
    });
}

/// Somebody deletes a scan twice, and it is created anew in between.
#[test]
fn a_scan_that_others_need_or_that_is_new_is_not_deleted() {
    let folder = Folder::new("deleted-twice");
    let server = Server::start(&folder.path("scans"));
    let robot = Robot::new(3, 80);
    for _ in 0..20 {
        let mut client = server.client();
        client.post("/scans", &robot.body("mug")).expect(201);
        let delete = || server.client().delete("/scans/mug").status;
        let both = std::thread::scope(|scope| {
            [scope.spawn(delete), scope.spawn(delete)].map(|deleting| deleting.join().unwrap())
        });
        assert!(
            both.contains(&200) && both.iter().all(|status| [200, 404, 409].contains(status)),
            "{both:?}"
        );
        assert_eq!(client.get("/scans").expect(200), json!([]));
    }
}
