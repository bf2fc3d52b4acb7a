//! A scan through the server is the scan without it.

use crate::client::Client;
use crate::process::{Folder, Server, n_from_env};
use crate::robot::{Robot, post_raw};
use crate::watcher::Watcher;
use nextview::Cancel;
use nextview_scan::{LiveFrame, LiveScan, ScanRun, result_file, rows_of_pose};
use serde_json::{Value, json};
use std::time::{Duration, Instant};

const N_VIEWS: usize = 12;

/// The outcome of a scan.
#[derive(Default)]
struct Outcome {
    views: Vec<Value>,
    map: Vec<u8>,
    /// Times from taking a frame until the next view is known.
    latencies: Vec<Duration>,
}

/// The scan in this process, as Python and Rust do it.
fn in_process(robot: &Robot) -> Outcome {
    let mut scan = LiveScan::begin(robot.live(), None, Cancel::default()).unwrap();
    let mut outcome = Outcome::default();
    let mut next = scan.next().unwrap();
    while let Some(view) = next {
        let rows = json!(rows_of_pose(&view.world_from_camera));
        let frame = robot.frame(&rows, scan.scan().steps.is_empty());
        outcome.views.push(json!(view.view));
        let taken = LiveFrame::new(frame.image().clone(), crate::robot::pose(&rows));
        let start = Instant::now();
        scan.observe(taken).unwrap();
        next = scan.next().unwrap();
        outcome.latencies.push(start.elapsed());
    }
    outcome.map = result_file("map.ot", scan.config(), scan.scan()).unwrap();
    outcome
}

fn through_server(robot: &Robot, client: &mut Client, id: &str) -> Outcome {
    client.post("/scans", &robot.body(id)).expect(201);
    scanned(robot, client, id)
}

/// A scan that was created.
fn scanned(robot: &Robot, client: &mut Client, id: &str) -> Outcome {
    let mut outcome = Outcome::default();
    let path = format!("/scans/{id}/next");
    let mut next = client.get(&path).expect(200);
    while next["state"] == "view" {
        let rows = &next["view"]["world_from_camera"];
        let frame = robot.frame(rows, outcome.views.is_empty());
        outcome.views.push(next["view"]["view"].clone());
        let start = Instant::now();
        post_raw(client, id, &outcome.views.len().to_string(), rows, frame.image()).expect(200);
        next = client.get(&path).expect(200);
        outcome.latencies.push(start.elapsed());
    }
    outcome.map = client.get(&format!("/scans/{id}/files/map.ot")).body;
    outcome
}

fn row(name: &str, mut latencies: Vec<Duration>) {
    latencies.sort();
    let at = |share: f64| 1e3 * latencies[((latencies.len() - 1) as f64 * share) as usize].as_secs_f64();
    println!("{name:<24} median {:7.1} ms   95 % {:7.1} ms   n {}", at(0.5), at(0.95), latencies.len());
}

/// `NEXTVIEW_SERVED` is the width of the images (320 by default); with 640, up to 16 scans run at once.
#[test]
fn views_and_map_are_the_same() {
    let width = n_from_env("NEXTVIEW_SERVED", 320);
    let robot = Robot::new(N_VIEWS, width as u32);
    let expected = in_process(&robot);
    row("in this process", expected.latencies.clone());

    let folder = Folder::new("same");
    let server = Server::start(&folder.path("scans"));
    for n_scans in if width >= 640 { vec![1, 4, 16] } else { vec![1, 3] } {
        let scan = |i: usize| {
            let id = format!("scan-{n_scans}-{i}");
            let outcome = through_server(&robot, &mut server.client(), &id);
            assert_eq!(outcome.views, expected.views, "{id}");
            assert!(outcome.map == expected.map, "{id}: another map");
            outcome.latencies
        };
        let start = Instant::now();
        let latencies: Vec<Duration> = std::thread::scope(|scope| {
            let scans: Vec<_> = (0..n_scans).map(|i| scope.spawn(move || scan(i))).collect();
            scans.into_iter().flat_map(|scan| scan.join().unwrap()).collect()
        });
        row(&format!("server, {n_scans} scans at once"), latencies);
        println!("    {n_scans} scans in {:.1} s, with rendering", start.elapsed().as_secs_f64());
    }
    assert_eq!(expected.views.len(), N_VIEWS);
}

/// A page that shows the scan live does not slow it down; `NEXTVIEW_SERVED` is the width of the images,
/// `NEXTVIEW_WATCHED` the number of frames.
#[test]
fn a_page_changes_nothing() {
    let n_views = n_from_env("NEXTVIEW_WATCHED", N_VIEWS);
    let robot = Robot::new(n_views, n_from_env("NEXTVIEW_SERVED", 320) as u32);
    let folder = Folder::new("watched");
    let server = Server::start(&folder.path("scans"));
    let alone = through_server(&robot, &mut server.client(), "alone");
    row("server, no page", alone.latencies);

    let watcher = Watcher::default();
    let mut client = server.client();
    client.post("/scans", &robot.body("watched")).expect(201);
    let watched = std::thread::scope(|scope| {
        scope.spawn(|| watcher.watch("watched", server.client(), server.client()));
        let outcome = scanned(&robot, &mut client, "watched");
        client.post("/scans/watched/finish", &json!({})).expect(200);
        outcome
    });
    row("server, a page open", watched.latencies);
    let (n_scenes, n_bytes) = (watcher.n_scenes.into_inner(), watcher.n_bytes.into_inner());
    println!("    {n_scenes} scenes, {:.0} kB each", n_bytes as f64 / 1e3 / n_scenes.max(1) as f64);
    assert_eq!(watched.views, alone.views);
    assert!(n_scenes > 1 && watched.map == alone.map);
}

/// With noise, the program knows the errors of the camera that it simulates, and decides by them.
#[test]
fn without_noise_so_are_those_of_the_program() {
    let robot = Robot::exact(N_VIEWS, 160);
    let (config, simulation) = robot.simulated();
    let mut run = ScanRun::begin(&simulation, config, nextview_scan::RunOptions::default()).unwrap();
    run.drive(|_| Ok(())).unwrap();
    let program: Vec<Value> = run.steps().iter().map(|step| json!(step.view)).collect();
    let map = result_file("map.ot", config, run.scan()).unwrap();
    let folder = Folder::new("program");
    let server = Server::start(&folder.path("scans"));
    let outcome = through_server(&robot, &mut server.client(), "mug");
    assert_eq!(outcome.views, program);
    assert!(outcome.map == map, "another map");
}
