//! The server is killed while clients post frames.

use crate::client::Client;
use crate::process::{Folder, Server, n_from_env};
use crate::robot::{Robot, raw};
use nextview::Cancel;
use nextview::geometry::random::Random;
use nextview_scan::{LiveFrame, LiveScan, rows_of_pose};
use serde_json::{Value, json};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::time::{Duration, Instant};

const N_VIEWS: usize = 8;
const N_SCANS: usize = 3;

/// A step of the uninterrupted scan.
struct Step {
    view: Value,
    id: String,
    path: String,
    body: Vec<u8>,
}

/// The steps of the scan without interruptions.
fn undisturbed(robot: &Robot) -> Vec<Step> {
    let mut scan = LiveScan::begin(robot.live(), None, Cancel::default()).unwrap();
    let mut steps = Vec::new();
    while let Some(view) = scan.next().unwrap() {
        let rows = json!(rows_of_pose(&view.world_from_camera));
        let frame = robot.frame(&rows, steps.is_empty());
        let id = format!("frame-{}", steps.len());
        let (path, body) = raw("SCAN", &id, &rows, frame.image());
        steps.push(Step { view: json!(view.view), id, path, body });
        scan.observe(LiveFrame::new(frame.image().clone(), crate::robot::pose(&rows))).unwrap();
    }
    steps
}

/// Creates the scan if it does not exist; returns the number of its frames.
fn scan_on(client: &mut Client, id: &str, steps: &[Step], body: &Value) -> std::io::Result<usize> {
    // An acknowledged frame exists; one that was not acknowledged may exist.
    let text = body.to_string();
    let created = client.send("POST", "/scans", "application/json", text.as_bytes())?;
    assert!([201, 409].contains(&created.status), "{created:?}");
    let record = client.send("GET", &format!("/scans/{id}"), "", b"")?.expect(200);
    let n = record["n_frames"].as_u64().unwrap() as usize;
    assert!(n <= steps.len());
    Ok(n)
}

/// Kills the server again and again, at any time. `NEXTVIEW_KILLS` is the number of kills (5 by default).
#[test]
fn whenever_it_is_killed_no_acknowledged_frame_is_lost() {
    let n_kills = n_from_env("NEXTVIEW_KILLS", 5);
    let robot = Robot::new(N_VIEWS, 80);
    let steps = undisturbed(&robot);
    let folder = Folder::new("killed");
    let dir = folder.path("scans");
    let mut random = Random::new(n_kills as u64, 0);
    let acknowledged = Mutex::new(vec![0_usize; N_SCANS]);
    let round = Mutex::new(vec![0_usize; N_SCANS]);
    let (mut n_duplicates, mut n_scans, start) = (0, 0, Instant::now());
    let n_acknowledged = AtomicUsize::new(0);
    for i in 0..n_kills {
        let mut server = Server::start(&dir);
        let (address, before) = (server.address, n_acknowledged.load(Relaxed));
        let done = std::thread::scope(|scope| {
            let clients: Vec<_> = (0..N_SCANS)
                .map(|i| {
                    let (steps, robot, acknowledged, round) = (&steps, &robot, &acknowledged, &round);
                    let count = &n_acknowledged;
                    scope.spawn(move || drive(address, (i, robot, steps), (acknowledged, count), round))
                })
                .collect();
            // One in four at any time, also while scans are resumed; the others while frames are posted.
            while i % 4 > 0
                && n_acknowledged.load(Relaxed) == before
                && clients.iter().all(|c| !c.is_finished())
            {
                std::thread::sleep(Duration::from_millis(1));
            }
            std::thread::sleep(Duration::from_secs_f64(random.range(0.0, 0.25)));
            server.kill();
            clients.into_iter().map(|client| client.join().unwrap()).collect::<Vec<_>>()
        });
        n_duplicates += done.iter().map(|(duplicates, _)| duplicates).sum::<usize>();
        n_scans += done.iter().map(|(_, scans)| scans).sum::<usize>();
    }
    assert!(n_scans > 0 || n_kills < 50, "no scan came to its end: the kills came too early");
    println!(
        "{n_kills} times killed in {:.0} s; {n_scans} scans completed; {} frames acknowledged, and {n_duplicates} were \
         there without having been acknowledged",
        start.elapsed().as_secs_f64(),
        n_acknowledged.load(Relaxed)
    );
    // And without interruption to the end.
    let server = Server::start(&dir);
    for i in 0..N_SCANS {
        let id = format!("scan-{i}-{}", round.lock().unwrap()[i]);
        let client = &mut server.client();
        if acknowledged.lock().unwrap()[i] == steps.len() {
            continue;
        }
        let n = scan_on(client, &id, &steps, &robot.body(&id)).unwrap();
        assert!(n >= acknowledged.lock().unwrap()[i]);
        drive_from(client, &id, &steps, n, &mut |_| ()).unwrap();
        assert_eq!(client.get(&format!("/scans/{id}/next")).expect(200)["stop_reason"], "view-limit");
    }
}

/// A robot may be on its way while the server is killed, and need not ask again.
#[test]
fn a_frame_is_of_the_view_that_was_asked_for_before_a_kill() {
    let robot = Robot::new(3, 80);
    let steps = undisturbed(&robot);
    let folder = Folder::new("killed-on-the-way");
    let dir = folder.path("scans");
    let mut server = Server::start(&dir);
    server
        .client()
        .send("POST", "/scans", "application/json", robot.body("mug").to_string().as_bytes())
        .unwrap();
    for step in &steps {
        let next = server.client().get("/scans/mug/next").expect(200);
        server.kill();
        server = Server::start(&dir);
        let path = step.path.replace("SCAN", "mug");
        let answer = server.client().send("POST", &path, "application/octet-stream", &step.body);
        assert_eq!((&next["view"]["view"], &answer.unwrap().expect(200)["view"]), (&step.view, &step.view));
    }
    assert_eq!(server.client().get("/scans/mug/next").expect(200)["stop_reason"], "view-limit");
}

/// One client that runs one scan after the other until the server is gone; returns the numbers of frames that
/// existed already and of completed scans.
fn drive(
    address: std::net::SocketAddr,
    (i, robot, steps): (usize, &Robot, &[Step]),
    (acknowledged, count): (&Mutex<Vec<usize>>, &AtomicUsize),
    round: &Mutex<Vec<usize>>,
) -> (usize, usize) {
    let (mut n_duplicates, mut n_scans) = (0, 0);
    let next_round = |i: usize| {
        round.lock().unwrap()[i] += 1;
        acknowledged.lock().unwrap()[i] = 0;
    };
    let mut work = || -> std::io::Result<()> {
        let mut client = Client::try_new(address)?;
        loop {
            let id = format!("scan-{i}-{}", round.lock().unwrap()[i]);
            let n = scan_on(&mut client, &id, steps, &robot.body(&id))?;
            let known = acknowledged.lock().unwrap()[i];
            if known == steps.len() && n == 0 {
                // The scan was being deleted, so it was created again.
                client.send("DELETE", &format!("/scans/{id}"), "", b"")?.expect(200);
                next_round(i);
                continue;
            }
            assert!(n == known || n == known + 1, "{id}: {n} frames, {known} acknowledged");
            if n > 0 {
                // Posts the last frame again, like a client that does not know whether it arrived.
                let step = &steps[n - 1];
                let path = step.path.replace("SCAN", &id);
                let answer = client.send("POST", &path, "application/octet-stream", &step.body)?.expect(200);
                assert_eq!((&answer["duplicate"], &answer["frame"]), (&json!(true), &json!(step.id)));
            }
            n_duplicates += n - known;
            acknowledged.lock().unwrap()[i] = n;
            drive_from(&mut client, &id, steps, n, &mut |n| {
                acknowledged.lock().unwrap()[i] = n;
                count.fetch_add(1, Relaxed);
            })?;
            client.send("DELETE", &format!("/scans/{id}"), "", b"")?.expect(200);
            n_scans += 1;
            next_round(i);
        }
    };
    let _ = work();
    (n_duplicates, n_scans)
}

fn drive_from(
    client: &mut Client,
    id: &str,
    steps: &[Step],
    n_taken: usize,
    on_acknowledged: &mut dyn FnMut(usize),
) -> std::io::Result<()> {
    for (n, step) in steps.iter().enumerate().skip(n_taken) {
        let next = client.send("GET", &format!("/scans/{id}/next"), "", b"")?.expect(200);
        assert_eq!(next["view"]["view"], step.view, "{id}: view {n} is another one");
        let path = step.path.replace("SCAN", id);
        client.send("POST", &path, "application/octet-stream", &step.body)?.expect(200);
        on_acknowledged(n + 1);
    }
    Ok(())
}
