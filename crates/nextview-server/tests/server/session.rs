//! The requests of a client in the course of a scan.

use crate::process::{Folder, Server};
use crate::robot::{Robot, encoded, multipart, png, post_raw};
use serde_json::{Value, json};
use std::fs;

fn next(client: &mut crate::client::Client) -> Value {
    client.get("/scans/mug/next").expect(200)
}

/// A scan whose file is damaged does not prevent the others from continuing, and stays unchanged.
#[test]
fn a_scan_that_cannot_be_read_is_left_out() {
    let folder = Folder::new("damaged");
    let dir = folder.path("scans");
    let robot = Robot::new(3, 160);
    {
        let server = Server::start(&dir);
        let mut client = server.client();
        for id in ["mug", "torn", "odd"] {
            client.post("/scans", &robot.body(id)).expect(201);
        }
    }
    let [torn, odd] = ["torn", "odd"].map(|id| dir.join(id).join("server.json"));
    let text = fs::read_to_string(&odd).unwrap();
    fs::write(&torn, &text[..text.len() / 2]).unwrap();
    fs::write(&odd, text.replacen("voxel", "vexel", 1)).unwrap();
    let server = Server::start(&dir);
    let mut client = server.client();
    let ids = |client: &mut crate::client::Client| -> Vec<String> {
        let scans = client.get("/scans").expect(200);
        scans.as_array().unwrap().iter().map(|scan| scan["id"].as_str().unwrap().to_owned()).collect()
    };
    assert_eq!(ids(&mut client), ["mug"]);
    assert_eq!(next(&mut client)["state"], "view");
    assert_eq!(client.get("/scans/torn").status, 404);
    assert_eq!(client.post("/scans", &robot.body("torn")).status, 409);
    assert_eq!(fs::read_to_string(&torn).unwrap(), text[..text.len() / 2]);
}

#[test]
fn what_a_resumed_scan_has_lost_is_in_its_answer() {
    let folder = Folder::new("lost");
    let dir = folder.path("scans");
    let robot = Robot::new(3, 160);
    {
        let server = Server::start(&dir);
        let mut client = server.client();
        assert!(client.post("/scans", &robot.body("mug")).expect(201).get("damage").is_none());
        let rows = &next(&mut client)["view"]["world_from_camera"];
        post_raw(&mut client, "mug", "1", rows, robot.frame(rows, true).image()).expect(200);
    }
    let journal = dir.join("mug/scan.journal");
    let bytes = fs::read(&journal).unwrap();
    fs::write(&journal, &bytes[..bytes.len() - 100]).unwrap();
    let server = Server::start(&dir);
    let answer = server.client().get("/scans/mug").expect(200);
    let damage = answer["damage"].as_str().unwrap();
    assert!(damage.contains("scan.journal.damaged-1") && answer["n_frames"] == 0, "{damage}");
}

/// Without room, no scans and frames are accepted; existing scans continue once there is room again.
#[test]
fn a_server_without_room_takes_neither_scans_nor_frames() {
    let folder = Folder::new("full");
    let dir = folder.path("scans");
    let robot = Robot::new(3, 160);
    Server::start(&dir).client().post("/scans", &robot.body("mug")).expect(201);
    for (what, message, remedy) in [
        ("disk", "MB free, but", "free space on the server's disk"),
        ("memory", "MB of memory, and its limit is 0 MB", "finish or delete scans"),
    ] {
        let server = Server::full(&dir, what);
        let mut client = server.client();
        let view = next(&mut client);
        let rows = &view["view"]["world_from_camera"];
        let refused = [
            client.post("/scans", &robot.body("another")),
            post_raw(&mut client, "mug", "1", rows, robot.frame(rows, true).image()),
        ];
        for answer in refused {
            let fault = &answer.expect(503)["faults"][0];
            let (said, hint) = (fault["message"].as_str().unwrap(), fault["remedy"].as_str().unwrap());
            assert!(said.contains(message) && hint == remedy, "{fault}");
        }
    }
    let server = Server::start(&dir);
    let mut client = server.client();
    let rows = &next(&mut client)["view"]["world_from_camera"];
    post_raw(&mut client, "mug", "1", rows, robot.frame(rows, true).image()).expect(200);
}

#[test]
fn a_scan_from_its_creation_to_its_files() {
    let folder = Folder::new("whole");
    let server = Server::start(&folder.path("scans"));
    let (robot, mut client) = (Robot::new(3, 160), server.client());
    assert_eq!(client.get("/healthz").expect(200)["status"], "ok");
    let mut body = robot.body("mug");
    body["confirm_views"] = json!(true);
    assert_eq!(client.post("/scans", &body).expect(201)["id"], "mug");
    assert_eq!(client.post("/scans", &body).status, 409);
    let mut events = server.client();
    events
        .write(format!("GET /scans/mug/events HTTP/1.1\r\nhost: {}\r\n\r\n", server.address).as_bytes())
        .unwrap();

    while !events.line().unwrap().is_empty() {}

    // A proposed view can be accepted, another view cannot; a skipped view is never proposed again.
    let proposed = next(&mut client);
    assert_eq!(proposed["state"], "proposed");
    let view = proposed["view"]["view"].clone();
    assert_eq!(client.post("/scans/mug/accept", &json!({ "view": 59 })).status, 409);
    client.post("/scans/mug/skip", &json!({ "view": view, "reason": "out of reach" })).expect(200);
    let other = next(&mut client);
    assert_ne!(other["view"]["view"], view);
    client.post("/scans/mug/accept", &json!({ "view": other["view"]["view"] })).expect(200);
    let given = next(&mut client);
    assert_eq!((&given["state"], &given["view"]), (&json!("view"), &other["view"]));

    // While the scan is paused, no view is returned.
    client.post("/scans/mug/pause", &json!({})).expect(200);
    assert_eq!(next(&mut client)["state"], "paused");
    assert_eq!(client.post("/scans/mug/continue", &json!({})).expect(200)["state"], "running");

    // Frames in each of the three forms; each once, however often it is sent.
    let rows = &given["view"]["world_from_camera"];
    let frame = robot.frame(rows, true);
    let step = post_raw(&mut client, "mug", "a", rows, frame.image()).expect(200);
    assert_eq!((&step["step"], &step["frame"], &step["duplicate"]), (&json!(1), &json!("a"), &json!(false)));
    let again = post_raw(&mut client, "mug", "a", rows, frame.image()).expect(200);
    assert_eq!((&again["step"], &again["duplicate"]), (&json!(1), &json!(true)));
    let other = robot.frame(&next(&mut client)["view"]["world_from_camera"], false);
    assert_eq!(post_raw(&mut client, "mug", "a", rows, other.image()).status, 409);

    let rows = next(&mut client)["view"]["world_from_camera"].clone();
    let depth = robot.frame(&rows, false);
    let colors = encoded(160, 120, (png::ColorType::Rgb, png::BitDepth::Eight), &[100; 160 * 120 * 3]);
    let mask = encoded(160, 120, (png::ColorType::Grayscale, png::BitDepth::Eight), &[255; 160 * 120]);
    let head = json!({ "id": "b", "world_from_camera": rows }).to_string();
    let depth = png(depth.image());
    let parts = [("frame", head.as_bytes()), ("depth", &depth), ("color", &colors), ("mask", &mask)];
    let (kind, body) = multipart(&parts);
    let step = client.send("POST", "/scans/mug/frames", &kind, &body).unwrap().expect(200);
    assert_eq!((&step["step"], &step["frame"]), (&json!(2), &json!("b")));

    let rows = next(&mut client)["view"]["world_from_camera"].clone();
    let depth = png(robot.frame(&rows, false).image());
    let numbers: Vec<String> =
        rows.as_array().unwrap().iter().flat_map(|r| r.as_array().unwrap()).map(Value::to_string).collect();
    let path = format!("/scans/mug/frames?id=c&world_from_camera={}", numbers.join(","));
    assert_eq!(client.send("POST", &path, "image/png", &depth).unwrap().expect(200)["step"], 3);
    assert_eq!(next(&mut client), json!({ "state": "finished", "view": null, "stop_reason": "view-limit" }));

    // The files that exist during the scan, and afterwards.
    assert_eq!(client.get("/scans/mug/frames/2/color.png").status, 200);
    assert_eq!(client.get("/scans/mug/frames/1/color.png").status, 404);
    assert!(client.get("/scans/mug/frames/1/depth.png").body.starts_with(b"\x89PNG"));
    let cloud = client.get("/scans/mug/files/cloud.ply");
    assert!(cloud.status == 200 && cloud.body.starts_with(b"ply"));
    assert_eq!(client.get("/scans/mug/files/report.html").status, 409);
    assert_eq!(client.get("/scans/mug/export/tum").status, 409);
    let finished = client.post("/scans/mug/finish", &json!({})).expect(200);
    assert_eq!(finished["files"].as_array().unwrap().len(), 10, "{finished}");
    assert_eq!(client.post("/scans/mug/finish", &json!({})).expect(200)["record"], finished["record"]);
    assert_eq!(client.get("/scans/mug/files/cloud.ply").body, cloud.body);
    assert!(client.get("/scans/mug/files/report.html").body.starts_with(b"<!"));
    let exported = client.get("/scans/mug/export/tum");
    assert!(exported.status == 200 && exported.body.starts_with(b"intrinsics.txt\0"));
    assert_eq!(client.get("/scans/mug/export/colmap").status, 409, "not all frames have colour");
    assert_eq!(client.get("/scans/mug/export/zip").status, 404);
    assert_eq!(client.get("/scans").expect(200)[0]["state"], "finished");
    assert_eq!(post_raw(&mut client, "mug", "d", &rows, frame.image()).status, 409);

    // All of that was reported in events as it happened.
    let mut told = Vec::new();
    while told.last().is_none_or(|last| last != "finished") {
        told.extend(events.line().unwrap().strip_prefix("event: ").map(str::to_owned));
    }
    let expected = "view skipped view accepted paused continued frame view frame view frame finished";
    assert_eq!(told.join(" "), expected);

    // The scan still exists after the server has ended, until it is deleted; so does the content of the page.
    let shown = |client: &mut crate::client::Client| {
        let paths = ["scene", "scene?after=2", "frames/3/depth.png", "frames/2/color.png"];
        paths.map(|path| {
            let answer = client.get(&format!("/scans/mug/{path}"));
            assert_eq!(answer.status, 200, "{path}: {}", answer.message());
            answer.body
        })
    };
    let before = shown(&mut client);
    assert!(before[2].starts_with(b"\x89PNG") && before[3].starts_with(b"\x89PNG"));
    assert!(server.end());
    let server = Server::start(&folder.path("scans"));
    let mut client = server.client();
    let scan = client.get("/scans/mug").expect(200);
    assert_eq!(
        (&scan["state"], &scan["n_frames"], &scan["record"]),
        (&json!("finished"), &json!(3), &finished["record"])
    );
    assert_eq!(client.get("/scans/mug/files/cloud.ply").body, cloud.body);
    assert_eq!(shown(&mut client), before);
    assert_eq!(client.get("/scans/mug/frames/1/color.png").status, 404);
    assert_eq!(client.get("/scans/mug/frames/4/depth.png").status, 404);
    assert_eq!(next(&mut client)["stop_reason"], "view-limit");
    client.delete("/scans/mug").expect(200);
    assert_eq!(client.get("/scans").expect(200), json!([]));
    let left = fs::read_dir(folder.path("scans")).unwrap().map(|entry| entry.unwrap().file_name());
    assert_eq!(left.collect::<Vec<_>>(), [".nextview-serve.lock"]);
}

/// A batch is the next view and those that would follow it; asking for it changes nothing.
#[test]
fn a_batch_of_views_is_planned_ahead() {
    let folder = Folder::new("batch");
    let server = Server::start(&folder.path("scans"));
    let (robot, mut client) = (Robot::new(4, 160), server.client());
    client.post("/scans", &robot.body("mug")).expect(201);
    let batch = |client: &mut crate::client::Client, n: usize| {
        let answer = client.get(&format!("/scans/mug/next?batch={n}")).expect(200);
        let following = answer["following"].as_array().unwrap().clone();
        (answer["view"].clone(), following)
    };
    let frame = robot.frame(&next(&mut client)["view"]["world_from_camera"], true);
    let first = next(&mut client)["view"].clone();
    post_raw(&mut client, "mug", "a", &first["world_from_camera"], frame.image()).expect(200);

    let alone = next(&mut client);
    assert!(alone.get("following").is_none());
    let (view, following) = batch(&mut client, 3);
    assert_eq!((&view, following.len()), (&alone["view"], 2));
    assert_eq!(batch(&mut client, 1), (view.clone(), vec![]));
    assert_eq!(batch(&mut client, 100).1.len(), 2, "one of four views was taken");
    let all = [&[first, view.clone()], &following[..]].concat();
    let numbers: std::collections::BTreeSet<u64> =
        all.iter().map(|view| view["view"].as_u64().unwrap()).collect();
    assert_eq!(numbers.len(), 4, "no view comes twice");
    for pair in all[1..].windows(2) {
        assert!(pair[1]["expected_new_voxels"].as_f64().unwrap() > 0.0 && pair[1]["score"].is_number());
        let way = pair[1]["waypoints"].as_array().unwrap();
        let at = |row: usize, view: &Value| view["world_from_camera"][row][3].as_f64().unwrap();
        for (waypoint, view) in [(&way[0], &pair[0]), (&way[way.len() - 1], &pair[1])] {
            let off = (0..3).map(|row| (waypoint["position_m"][row].as_f64().unwrap() - at(row, view)).abs());
            assert!(off.fold(0.0, f64::max) < 1e-9);
        }
    }
    assert_eq!(next(&mut client), alone);

    // All are taken on one trip; the scan then continues from there.
    for (i, view) in all[1..].iter().enumerate() {
        let rows = &view["world_from_camera"];
        let step = post_raw(&mut client, "mug", &i.to_string(), rows, robot.frame(rows, false).image());
        assert_eq!(step.expect(200)["view"].is_number(), i == 0);
    }
    assert_eq!(next(&mut client)["state"], "view");
    for (query, status) in [("batch=0", 422), ("batch=101", 422), ("batch=x", 400), ("bach=2", 400)] {
        assert_eq!(client.get(&format!("/scans/mug/next?{query}")).status, status, "{query}");
    }
}

#[test]
fn a_listener_that_comes_back_misses_nothing() {
    let folder = Folder::new("events");
    let server = Server::start(&folder.path("scans"));
    let (robot, mut client) = (Robot::new(2, 80), server.client());
    client.post("/scans", &robot.body("mug")).expect(201);
    let told = |last: &str, n: usize| {
        let mut events = server.client();
        let last = if last.is_empty() { String::new() } else { format!("last-event-id: {last}\r\n") };
        let head = format!("GET /scans/mug/events HTTP/1.1\r\nhost: {}\r\n{last}\r\n", server.address);
        events.write(head.as_bytes()).unwrap();
        while !events.line().unwrap().is_empty() {}
        std::thread::sleep(std::time::Duration::from_millis(50));
        client.post("/scans/mug/pause", &json!({})).expect(200);
        client.post("/scans/mug/continue", &json!({})).expect(200);
        let (mut names, mut ids) = (Vec::new(), Vec::new());
        while names.len() < n || ids.len() < n {
            let line = events.line().unwrap();
            names.extend(line.strip_prefix("event: ").map(str::to_owned));
            ids.extend(line.strip_prefix("id: ").map(str::to_owned));
        }
        (names, ids)
    };
    let mut told = told;
    let (names, ids) = told("", 2);
    assert_eq!(names, ["paused", "continued"]);
    let (names, more) = told(&ids[0], 3);
    assert_eq!(
        (names, &more[0]),
        (["continued", "paused", "continued"].map(str::to_owned).to_vec(), &ids[1])
    );
    assert_eq!(told("of-another-process-7", 3).0, ["gap", "paused", "continued"]);
}

/// Takes all frames of a scan and finishes it; returns its record.
fn scan_through(client: &mut crate::client::Client, robot: &Robot, id: &str) -> Value {
    for number in 1.. {
        let next = client.get(&format!("/scans/{id}/next")).expect(200);
        if next["state"] == "finished" {
            break;
        }
        let rows = &next["view"]["world_from_camera"];
        let frame = robot.frame(rows, number == 1);
        post_raw(client, id, &number.to_string(), rows, frame.image()).expect(200);
    }
    client.post(&format!("/scans/{id}/finish"), &json!({})).expect(200)["record"].clone()
}

#[test]
fn a_scan_goes_on_after_its_object_was_turned() {
    let folder = Folder::new("turned");
    let dir = folder.path("scans");
    let server = Server::start(&dir);
    let (robot, mut client) = (Robot::on_table(6, 320), server.client());
    client.post("/scans", &robot.body("mug")).expect(201);
    let after = json!({ "after": "mug", "id": "turned" });
    assert_eq!(client.post("/scans", &after).status, 422, "it is not finished");
    assert_eq!(client.post("/scans", &json!({ "after": "../mug" })).status, 422, "there is none");
    let before = scan_through(&mut client, &robot, "mug");
    assert!(before["next_placement"].is_object(), "{before}");
    let scene = String::from_utf8(client.get("/scans/mug/scene").body).unwrap();
    assert!(scene.contains("To see more, turn the object"), "the page asks for it");

    let turned = robot.turned(dir.join("mug"));
    let poses = turned.body("turned")["live"].clone();
    // The server closes idle connections, and turning took a while.
    let mut client = server.client();
    let body = json!({ "after": "mug", "id": "turned", "live": poses });
    client.post("/scans", &body).expect(201);
    let refused = client.delete("/scans/mug").expect(409);
    assert_eq!(
        refused["faults"][0]["remedy"], "finish or delete `turned` first",
        "it reads the frames of mug"
    );
    // The folder of all scans is moved and served from another place: both scans still exist, and one still
    // needs the other.
    let rows = client.get("/scans/turned/next").expect(200)["view"]["world_from_camera"].clone();
    post_raw(&mut client, "turned", "0", &rows, turned.frame(&rows, true).image()).expect(200);
    assert!(server.end());
    let moved = folder.path("moved");
    fs::rename(&dir, &moved).unwrap();
    let server = Server::start(&moved);
    let mut client = server.client();
    assert_eq!(client.get("/scans/turned").expect(200)["n_frames"], 1);
    assert_eq!(client.delete("/scans/mug").status, 409);
    let now = scan_through(&mut client, &turned, "turned");
    let turn = &now["turn"];
    assert!(turn["refusal"].is_null() && turn["overlap"].as_f64().unwrap() > 0.3, "{turn}");
    // Missing keys come from the configuration of the earlier scan.
    let config = fs::read_to_string(moved.join("turned/config.toml")).unwrap();
    assert!(config.contains("voxel_size_m = 0.006") && config.contains("after = \"../mug\""), "{config}");
    client.delete("/scans/mug").expect(200);
}
