//! A camera that does not know its pose.

use crate::process::{Folder, Server};
use crate::robot::{Robot, png};
use serde_json::{Value, json};

#[test]
fn a_camera_in_a_hand_is_located_and_guided() {
    let folder = Folder::new("hand");
    let server = Server::start(&folder.path("scans"));
    let (robot, mut client) = (Robot::new(3, 160), server.client());
    let mut body = robot.body("mug");
    let post = |client: &mut crate::client::Client, path: &str, image: &[u8]| {
        client.send("POST", path, "image/png", image).unwrap()
    };

    // A client that does not state that poses are tracked is told how to state it.
    client.post("/scans", &body).expect(201);
    let first = client.get("/scans/mug/next").expect(200)["view"]["world_from_camera"].clone();
    let image = png(robot.frame(&first, true).image());
    let refused = post(&mut client, "/scans/mug/frames?id=a", &image);
    assert_eq!(refused.status, 422, "{}", refused.message());
    assert!(refused.json()["faults"][0]["remedy"].as_str().unwrap().contains("tracked"));
    client.delete("/scans/mug").expect(200);

    body["registration"]["enabled"] = json!(true);
    body["registration"]["given_poses"] = json!("tracked");
    let pose = crate::robot::pose(&first);
    body["live"]["first_pose"] = serde_json::to_value(pose).unwrap();
    client.post("/scans", &body).expect(201);
    let mut events = server.client();
    events
        .write(format!("GET /scans/mug/events HTTP/1.1\r\nhost: {}\r\n\r\n", server.address).as_bytes())
        .unwrap();
    while !events.line().unwrap().is_empty() {}
    client.get("/scans/mug/next").expect(200);
    post(&mut client, "/scans/mug/frames?id=a", &image).expect(200);
    // Sent again, it counts once.
    assert_eq!(post(&mut client, "/scans/mug/frames?id=a", &image).expect(200)["duplicate"], true);

    let located = post(&mut client, "/scans/mug/locate", &image).expect(200);
    let at = |rows: &Value, row: usize| rows[row][3].as_f64().unwrap();
    let off = (0..3).map(|row| (at(&located["world_from_camera"], row) - at(&first, row)).abs());
    assert!(off.fold(0.0, f64::max) < 0.01, "{located}");
    let guided = client.post("/scans/mug/guidance", &json!({ "world_from_camera": first })).expect(200);
    let next = client.get("/scans/mug/next").expect(200)["view"]["world_from_camera"].clone();
    let there: f64 = (0..3).map(|row| (at(&next, row) - at(&first, row)).powi(2)).sum();
    assert!((guided["guidance"]["distance_m"].as_f64().unwrap() - there.sqrt()).abs() < 1e-9);
    assert_eq!(guided["guidance"]["reached"], false);

    // An image that shows nothing cannot be located.
    let nothing = png(&nextview::sensor::DepthImage::from_metres(160, 120, vec![3.0; 160 * 120]).unwrap());
    let lost = post(&mut client, "/scans/mug/locate", &nothing);
    assert_eq!(lost.status, 409);
    assert!(lost.message().contains("the camera is lost"), "{}", lost.message());
    let mut told = Vec::new();
    while told.last().is_none_or(|line: &String| !line.contains("\"lost\":true")) {
        told.push(events.line().unwrap());
    }
    assert!(
        told.iter().any(|line| line == "event: pose") && told.iter().any(|line| line == "event: tracking")
    );
}
