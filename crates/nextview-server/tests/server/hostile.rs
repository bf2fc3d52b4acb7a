//! Malicious requests, and requests that no client sends.

use crate::client::{Answer, Client};
use crate::process::{Folder, Server, n_from_env};
use crate::robot::{Robot, encoded, multipart, png, post_raw};
use nextview::geometry::random::Random;
use png::{BitDepth, ColorType};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::io::{Error, ErrorKind};
use std::net::SocketAddr;
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// The material for hostile requests.
struct Material {
    address: SocketAddr,
    /// A valid frame of an existing scan.
    rows: Value,
    png: Vec<u8>,
    config: Value,
}

/// The outcome of a request: a JSON answer, or an error if the connection was closed.
type Outcome = std::io::Result<Answer>;

/// A kind of request, by its name and a function of the material and a random number.
type Kind = (&'static str, fn(&Material, u64) -> Outcome);

impl Material {
    fn client(&self) -> Client {
        // Another request may hold all connections at the moment.
        for _ in 0..100 {
            if let Ok(client) = Client::try_new(self.address) {
                return client;
            }
            std::thread::sleep(Duration::from_millis(20));
        }
        panic!("the server takes no connections");
    }

    fn send(&self, method: &str, path: &str, kind: &str, body: &[u8]) -> Outcome {
        self.client().send(method, path, kind, body)
    }

    fn post(&self, path: &str, value: &Value) -> Outcome {
        self.send("POST", path, "application/json", value.to_string().as_bytes())
    }

    /// A scan with one key changed.
    fn scan_with(&self, change: impl FnOnce(&mut Value)) -> Outcome {
        let mut config = self.config.clone();
        change(&mut config);
        self.post("/scans", &config)
    }

    /// A multipart frame with one thing changed.
    fn frame(&self, head: Value, depth: &[u8], more: &[(&str, &[u8])]) -> Outcome {
        let head = head.to_string();
        let parts = [&[("frame", head.as_bytes()), ("depth", depth)], more].concat();
        let (kind, body) = multipart(&parts);
        self.send("POST", "/scans/mug/frames", &kind, &body)
    }

    fn head(&self) -> Value {
        json!({ "id": "hostile", "world_from_camera": self.rows })
    }

    fn raw(&self, text: &str) -> Outcome {
        let text = text.replace("HOST", &format!("host: {}\r\n", self.address));
        self.client().raw(text.as_bytes())
    }
}

/// A PNG without pixels, whose header claims a size.
fn claiming(width: u32, height: u32) -> Vec<u8> {
    let mut png = encoded(8, 6, (ColorType::Grayscale, BitDepth::Sixteen), &[0; 96]);
    png[16..20].copy_from_slice(&width.to_be_bytes());
    png[20..24].copy_from_slice(&height.to_be_bytes());
    let mut crc = 0xffff_ffff_u32;
    for byte in &png[12..29] {
        crc ^= u32::from(*byte);
        (0..8).for_each(|_| crc = if crc & 1 == 1 { (crc >> 1) ^ 0xedb8_8320 } else { crc >> 1 });
    }
    png[29..33].copy_from_slice(&(!crc).to_be_bytes());
    png
}

fn garbage(seed: u64, n: usize) -> Vec<u8> {
    let mut random = Random::new(seed, 3);
    (0..n).map(|_| random.index(256) as u8).collect()
}

const OCTETS: &str = "application/octet-stream";

const KINDS: &[Kind] = &[
    ("unknown path", |m, n| m.send("GET", &format!("/{n}/passwd"), "", b"")),
    ("path out of the folder", |m, _| m.send("GET", "/scans/mug/files/../../../../etc/passwd", "", b"")),
    ("path out, encoded", |m, _| m.send("GET", "/scans/mug/files/..%2f..%2fserver.json", "", b"")),
    ("file that is not a result", |m, _| m.send("GET", "/scans/mug/files/scan.journal", "", b"")),
    ("scan named as a path", |m, _| m.scan_with(|c| c["id"] = json!("../../tmp/x"))),
    ("scan named as no text", |m, n| m.scan_with(|c| c["id"] = json!(n))),
    ("id with a zero byte", |m, _| m.send("GET", "/scans/%00/next", "", b"")),
    ("id that is no UTF-8", |m, _| m.send("GET", "/scans/%ff%fe/next", "", b"")),
    ("wrong method", |m, n| {
        m.send(["PUT", "PATCH", "DELETE", "OPTIONS"][n as usize % 4], "/scans/mug/frames", "", b"")
    }),
    ("wrong token", |m, n| {
        let headers = format!("authorization: Bearer {n:064x}\r\n");
        m.client().with_headers(&headers).send("GET", "/scans", "", b"")
    }),
    ("browser without a token", |m, _| {
        m.client().with_headers("sec-fetch-site: same-origin\r\n").send("DELETE", "/scans/mug", "", b"")
    }),
    ("page of another host", |m, _| {
        m.client().with_headers("origin: http://evil.example\r\n").send("DELETE", "/scans/mug", "", b"")
    }),
    ("another host", |m, _| m.client().raw(b"GET /scans HTTP/1.1\r\nhost: evil.example\r\n\r\n")),
    ("no host", |m, _| m.client().raw(b"GET /scans HTTP/1.1\r\n\r\n")),
    ("two hosts", |m, _| m.raw("GET /scans HTTP/1.1\r\nHOSTHOST\r\n")),
    ("no HTTP", |m, n| m.client().raw(&[&garbage(n, 300)[..], b"\r\n\r\n"].concat())),
    ("endless head", |m, _| m.raw(&format!("GET /scans HTTP/1.1\r\nHOSTx: {}\r\n\r\n", "y".repeat(600_000)))),
    ("too many headers", |m, _| m.raw(&format!("GET /scans HTTP/1.1\r\nHOST{}\r\n", "x: y\r\n".repeat(200)))),
    ("slow head", |m, _| {
        let mut client = m.client();
        client.write(b"GET /scans HTT")?;
        client.answer()
    }),
    ("slow body", |m, _| {
        let mut client = m.client();
        client.write(
            format!("POST /scans HTTP/1.1\r\nhost: {}\r\ncontent-length: 900\r\n\r\n{{", m.address)
                .as_bytes(),
        )?;
        client.answer()
    }),
    ("body that ends early", |m, _| {
        let mut client = m.client();
        client.write(
            format!("POST /scans HTTP/1.1\r\nhost: {}\r\ncontent-length: 900\r\n\r\n{{", m.address)
                .as_bytes(),
        )?;
        drop(client);
        Err(ErrorKind::UnexpectedEof.into())
    }),
    ("body that claims to be huge", |m, _| {
        m.raw("POST /scans HTTP/1.1\r\nHOSTcontent-length: 99999999999999\r\n\r\n{}")
    }),
    ("length that is none", |m, _| m.raw("POST /scans HTTP/1.1\r\nHOSTcontent-length: -5\r\n\r\n{}")),
    ("length and chunks", |m, _| {
        m.raw("POST /scans HTTP/1.1\r\nHOSTcontent-length: 5\r\ntransfer-encoding: chunked\r\n\r\n0\r\n\r\n")
    }),
    ("body that is too large", |m, _| {
        m.send("POST", "/scans/mug/frames?id=x", "image/png", &vec![0; 1_100_000])
    }),
    ("chunks without end", |m, _| {
        let mut client = m.client();
        let head =
            format!("POST /scans HTTP/1.1\r\nhost: {}\r\ntransfer-encoding: chunked\r\n\r\n", m.address);
        client.write(head.as_bytes())?;
        let chunk = [format!("{:x}\r\n", 1 << 16).as_bytes(), &vec![b' '; 1 << 16], b"\r\n"].concat();
        let sent: std::io::Result<()> = (0..64).try_for_each(|_| client.write(&chunk));
        client.answer().or_else(|error| sent.and(Err(error)))
    }),
    ("broken chunks", |m, _| {
        m.raw("POST /scans HTTP/1.1\r\nHOSTtransfer-encoding: chunked\r\n\r\nzz\r\n{}\r\n")
    }),
    ("empty JSON", |m, _| m.send("POST", "/scans", "application/json", b"")),
    ("broken JSON", |m, n| m.send("POST", "/scans", "application/json", &garbage(n, 200))),
    ("JSON of another type", |m, n| {
        m.post("/scans", &[json!(null), json!([]), json!(3), json!("x")][n as usize % 4])
    }),
    ("deep JSON", |m, _| m.send("POST", "/scans", "application/json", &[b'['; 100_000])),
    ("content of another type", |m, _| m.send("POST", "/scans", "text/xml", b"<x/>")),
    ("key that there is not", |m, _| m.scan_with(|c| c["voxel_size"] = json!(0.1))),
    ("values of wrong types", |m, n| {
        m.scan_with(|c| c[["views", "seed", "camera", "live"][n as usize % 4]] = json!({ "x": [n] }))
    }),
    ("values out of their ranges", |m, n| {
        let (key, value) = [
            ("voxel_size_m", json!(-1)),
            ("voxel_size_m", json!(1e-9)),
            ("candidates", json!(1e15 as u64)),
            ("views", json!(0)),
            ("memory_limit_mb", json!(1_000_000_000)),
            ("time_limit_s", json!(-3)),
        ][n as usize % 6]
            .clone();
        m.scan_with(|c| c[key] = value)
    }),
    ("box of no size", |m, _| m.scan_with(|c| c["live"]["box_m"] = json!([0, 0, 0, 0, 0, 0]))),
    ("box of a planet", |m, _| {
        m.scan_with(|c| c["live"]["box_m"] = json!([-1e6, -1e6, -1e6, 1e6, 1e6, 1e6]))
    }),
    ("camera of no pixels", |m, _| m.scan_with(|c| c["camera"]["width"] = json!(0))),
    ("camera of too many pixels", |m, _| {
        m.scan_with(|c| (c["camera"]["width"], c["camera"]["height"]) = (json!(65_535), json!(65_535)))
    }),
    ("files of the server", |m, n| {
        m.scan_with(|c| match n % 6 {
            0 => c["sensor"] = json!("/etc/passwd.toml"),
            1 => c["nbv_net"] = json!({ "weights": "/etc/passwd" }),
            2 => c["reference"] = json!({ "mesh": "/etc/passwd" }),
            3 => c["robot"] = json!({ "arm": "/etc/passwd" }),
            4 => c["view_space"] = json!("/etc/passwd"),
            _ => c["recording"] = json!({ "truth": "/etc/passwd" }),
        })
    }),
    ("scan without end of ids", |m, n| m.scan_with(|c| c["id"] = json!("a".repeat(65 + n as usize % 1000)))),
    ("frame of no scan", |m, n| m.send("POST", &format!("/scans/none-{n}/frames"), "image/png", &m.png)),
    ("frame without parts", |m, _| {
        m.send("POST", "/scans/mug/frames", "multipart/form-data; boundary=x", b"--x--")
    }),
    ("frame without a boundary", |m, _| m.send("POST", "/scans/mug/frames", "multipart/form-data", b"x")),
    ("unknown part", |m, _| m.frame(m.head(), &m.png, &[("exe", b"x")])),
    ("part that comes twice", |m, _| m.frame(m.head(), &m.png, &[("depth", &m.png)])),
    ("frame without a pose", |m, _| m.frame(json!({ "id": "x" }), &m.png, &[])),
    ("pose with NaN", |m, _| {
        let (kind, body) =
            multipart(&[("frame", b"{\"id\":\"x\",\"world_from_camera\":[[NaN]]}"), ("depth", &m.png)]);
        m.send("POST", "/scans/mug/frames", &kind, &body)
    }),
    ("pose with NaN in the query", |m, _| {
        let path = format!("/scans/mug/frames?id=x&world_from_camera={}", ["NaN"; 16].join(","));
        m.send("POST", &path, "image/png", &m.png)
    }),
    ("pose that mirrors or stretches", |m, n| {
        let s = if n % 2 == 0 { -1.0 } else { 1e30 };
        let rows = json!([[s, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]);
        m.frame(json!({ "id": "x", "world_from_camera": rows }), &m.png, &[])
    }),
    ("pose of too few numbers", |m, n| {
        let path =
            format!("/scans/mug/frames?id=x&world_from_camera={}", vec!["1"; n as usize % 16].join(","));
        m.send("POST", &path, "image/png", &m.png)
    }),
    ("depth scale of zero or less", |m, n| {
        let mut head = m.head();
        head["depth_scale_m"] = [json!(0), json!(-1), json!(1e300)][n as usize % 3].clone();
        m.frame(head, &m.png, &[])
    }),
    ("camera that is not the scan's", |m, _| {
        let mut head = m.head();
        head["camera"] = json!({ "width": 9, "height": 9, "fx": 9, "fy": 9, "cx": 4, "cy": 4 });
        m.frame(head, &m.png, &[])
    }),
    ("id without an end", |m, _| {
        let mut head = m.head();
        head["id"] = json!("x".repeat(10_000));
        m.frame(head, &m.png, &[])
    }),
    ("image of no pixels", |m, _| m.frame(m.head(), &claiming(0, 0), &[])),
    ("image that claims to be huge", |m, _| m.frame(m.head(), &claiming(0x7fff_ffff, 0x7fff_ffff), &[])),
    ("decompression bomb", |m, _| {
        // Ten million pixels of zeros in ten thousand bytes.
        let zeros = encoded(4000, 2500, (ColorType::Grayscale, BitDepth::Sixteen), &vec![0; 20_000_000]);
        m.frame(m.head(), &zeros, &[])
    }),
    ("bomb that claims the right size", |m, _| {
        let mut zeros = encoded(4000, 250, (ColorType::Grayscale, BitDepth::Sixteen), &vec![0; 2_000_000]);
        zeros.splice(8..33, claiming(80, 60)[8..33].iter().copied());
        let head = m.head().to_string();
        let (kind, body) = multipart(&[("frame", head.as_bytes()), ("depth", &zeros)]);
        m.send("POST", "/scans/other/frames", &kind, &body)
    }),
    ("truncated image", |m, n| m.frame(m.head(), &m.png[..n as usize % m.png.len()], &[])),
    ("damaged image", |m, n| {
        let mut png = m.png.clone();
        let at = 8 + n as usize % (png.len() - 8);
        png[at] ^= 0x55;
        m.frame(m.head(), &png, &[])
    }),
    ("depth of 8 bits", |m, _| {
        m.frame(m.head(), &encoded(80, 60, (ColorType::Grayscale, BitDepth::Eight), &[9; 4800]), &[])
    }),
    ("colours that are none", |m, n| m.frame(m.head(), &m.png, &[("color", &garbage(n, 500))])),
    ("JPEG that is none", |m, n| {
        m.frame(m.head(), &m.png, &[("color", &[&[0xff, 0xd8, 0xff, 0xe0][..], &garbage(n, 500)].concat())])
    }),
    ("mask of another size", |m, _| {
        let mask = encoded(8, 6, (ColorType::Grayscale, BitDepth::Eight), &[1; 48]);
        m.frame(m.head(), &m.png, &[("mask", &mask)])
    }),
    ("numbers without a shape", |m, _| m.send("POST", "/scans/mug/frames?id=x", OCTETS, &[0; 9600])),
    ("numbers of a huge shape", |m, _| {
        let path = "/scans/mug/frames?id=x&width=4294967295&height=4294967295&dtype=f32\
                    &world_from_camera=1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1";
        m.send("POST", path, OCTETS, &[0; 9600])
    }),
    ("too few numbers", |m, _| {
        let path = "/scans/mug/frames?id=x&width=80&height=60&dtype=u16\
                    &world_from_camera=1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1";
        m.send("POST", path, OCTETS, &[0; 77])
    }),
    ("numbers of no type", |m, _| m.send("POST", "/scans/mug/frames?id=x&dtype=i64", OCTETS, b"")),
    ("other content under an id", |m, n| {
        let mut head = m.head();
        head["id"] = json!("taken");
        head["depth_scale_m"] = json!(0.002 + (n % 1000) as f64 * 1e-6);
        m.frame(head, &m.png, &[])
    }),
    ("view that there is not", |m, n| m.post("/scans/mug/skip", &json!({ "view": 1_000_000 + n }))),
    ("view that is no number", |m, _| m.post("/scans/mug/skip", &json!({ "view": -1 }))),
    ("view that is not proposed", |m, n| m.post("/scans/mug/accept", &json!({ "view": 1000 + n }))),
    ("reason without an end", |m, _| {
        m.post("/scans/mug/skip", &json!({ "view": 1, "reason": "x".repeat(100_000) }))
    }),
    ("step that there is not", |m, n| m.send("GET", &format!("/scans/mug/frames/{n}999/depth.png"), "", b"")),
    ("step that is no number", |m, _| m.send("GET", "/scans/mug/frames/-1/depth.png", "", b"")),
    ("unknown key in the query", |m, _| m.send("GET", "/scans/mug/scene?before=3", "", b"")),
    ("finished twice at once", |m, n| {
        let id = format!("twice-{}", n % 2);
        let _ = m.scan_with(|c| c["id"] = json!(id));
        let finish = || m.send("POST", &format!("/scans/{id}/finish"), "", b"");
        let both =
            std::thread::scope(|scope| [scope.spawn(finish), scope.spawn(finish)].map(|f| f.join().unwrap()));
        for answer in both.into_iter().flatten() {
            assert!([200, 404, 409, 429, 500, 503].contains(&answer.status), "{answer:?}");
        }
        let _ = m.send("DELETE", &format!("/scans/{id}"), "", b"");
        m.send("GET", &format!("/scans/{id}-gone"), "", b"")
    }),
    ("events of a browser", |m, _| {
        m.client().with_headers("origin: http://localhost:1\r\n").send("GET", "/scans/mug/events", "", b"")
    }),
];

/// For each kind of request, the number of answers with each status.
type Table = BTreeMap<&'static str, BTreeMap<String, usize>>;

/// `NEXTVIEW_HOSTILE` is the number of requests (600 if it is not set).
#[test]
fn every_hostile_request_is_told_its_cause() {
    let n = n_from_env("NEXTVIEW_HOSTILE", 600);
    let folder = Folder::new("hostile");
    let mut server = Server::tight(&folder.path("scans"));
    let robot = Robot::new(5, 80);
    let client = &mut server.client();
    client.post("/scans", &robot.body("mug")).expect(201);
    client.post("/scans", &robot.body("other")).expect(201);
    let rows = client.get("/scans/mug/next").expect(200)["view"]["world_from_camera"].clone();
    let frame = robot.frame(&rows, true);
    post_raw(client, "mug", "taken", &rows, frame.image()).expect(200);
    let before = client.get("/scans/mug/next").expect(200);
    let mut config = robot.body("hostile");
    config["planner"] = json!("random");
    let material = Material { address: server.address, rows, png: png(frame.image()), config };
    let table: Mutex<Table> = Mutex::default();
    let start = Instant::now();
    std::thread::scope(|scope| {
        for worker in 0..8 {
            let (material, table) = (&material, &table);
            scope.spawn(move || (worker..n).step_by(8).for_each(|i| try_kind(material, i, table)));
        }
    });
    assert!(server.is_running(), "the server has ended");
    // Nothing has changed, and nothing is blocked.
    let client = &mut server.client();
    assert_eq!(client.get("/scans/mug/next").expect(200), before);
    assert_eq!(client.get("/scans/mug").expect(200)["n_frames"], 1);
    let peak = server.peak_mb();
    assert!(peak.is_none_or(|peak| peak < 1500.0), "{peak:?} MB");
    let seconds = start.elapsed().as_secs_f64();
    println!("{n} hostile requests in {seconds:.0} s, of {} kinds; peak memory {peak:.0?} MB", KINDS.len());
    for (kind, outcomes) in table.into_inner().unwrap() {
        let outcomes: Vec<String> = outcomes.iter().map(|(outcome, n)| format!("{outcome} x {n}")).collect();
        println!("  {kind:<34} {}", outcomes.join(", "));
    }
}

/// Kinds of requests that are not valid HTTP, so they need no answer.
const NO_ANSWER: [&str; 3] = ["slow head", "body that ends early", "no HTTP"];

fn try_kind(material: &Material, i: usize, table: &Mutex<Table>) {
    let (kind, request) = KINDS[i % KINDS.len()];
    let start = Instant::now();
    let outcome = match request(material, (i / KINDS.len()) as u64) {
        Ok(answer) => checked(kind, &answer),
        Err(error) if is_closed(&error) => "closed".to_owned(),
        Err(error) => panic!("{kind}: {error}"),
    };
    assert!(start.elapsed() < Duration::from_secs(30), "{kind}: {:?}", start.elapsed());
    assert!(
        outcome != "closed" || NO_ANSWER.contains(&kind) || kind.contains("large") || kind.contains("end"),
        "{kind}"
    );
    *table.lock().unwrap().entry(kind).or_default().entry(outcome).or_default() += 1;
}

fn is_closed(error: &Error) -> bool {
    matches!(error.kind(), ErrorKind::UnexpectedEof | ErrorKind::ConnectionReset | ErrorKind::BrokenPipe)
}

/// The status of an answer, which must be a refusal with a cause.
fn checked(kind: &str, answer: &Answer) -> String {
    // More pixels than the size needs are ignored: the image is valid, and this does no harm.
    if answer.status == 200 && kind == "bomb that claims the right size" {
        return "200".to_owned();
    }
    assert!((400..600).contains(&answer.status) && answer.status != 500, "{kind}: {answer:?}");
    // A request that is not HTTP is refused before it reaches the server's code.
    if answer.body.is_empty() {
        return format!("{} bare", answer.status);
    }
    let faults = answer.json();
    let faults = faults["faults"].as_array().unwrap_or_else(|| panic!("{kind}: {answer:?}"));
    let has_cause = |fault: &Value| fault["message"].as_str().is_some_and(|message| message.len() > 5);
    assert!(!faults.is_empty() && faults.iter().all(has_cause), "{kind}: {answer:?}");
    answer.status.to_string()
}
