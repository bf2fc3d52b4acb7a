//! Who may send requests.

use crate::client::Client;
use crate::process::{Folder, Server};
use serde_json::Value;

fn status(server: &Server, method: &str, path: &str, headers: &str) -> (u16, String) {
    let mut client = server.client().with_headers(headers);
    let answer = client.send(method, path, "", b"").unwrap();
    (answer.status, answer.head)
}

#[test]
fn pages_of_others_may_ask_for_nothing() {
    let folder = Folder::new("access");
    let server = Server::start(&folder.path("scans"));
    let of = |headers: &str| status(&server, "GET", "/scans", headers).0;
    let own = format!("origin: http://{}\r\n", server.address);
    let token = format!("authorization: Bearer {}\r\n", server.token);
    assert_eq!(of(""), 200, "no browser");
    assert_eq!(of(&own), 401, "the page without its token");
    assert_eq!(of("sec-fetch-site: same-origin\r\n"), 401);
    assert_eq!(of(&format!("{own}{token}")), 200);
    assert_eq!(of(&format!("origin: http://evil.example\r\n{token}")), 403);
    assert_eq!(of(&format!("origin: null\r\n{token}")), 403);
    assert_eq!(of("authorization: Bearer 0123456789abcdef\r\n"), 401);
    assert_eq!(of("authorization: Basic YTpi\r\n"), 401);
    // Browsers that do not state the origin of a request, and programs that are not browsers.
    assert_eq!(of("referer: http://evil.example/\r\n"), 401);
    assert_eq!(of("user-agent: Mozilla/5.0 (X11; Linux x86_64) Gecko/20100101 Firefox/89.0\r\n"), 401);
    assert_eq!(of("user-agent: AppleCoreMedia/1.0\r\naccept-language: en-us\r\n"), 401);
    assert_eq!(of("user-agent: curl/8.5.0\r\naccept: */*\r\n"), 200);
    assert_eq!(of("user-agent: node\r\naccept-language: *\r\nsec-fetch-mode: cors\r\n"), 200);
    let line = |uri: &str| format!("GET {uri} HTTP/1.1\r\nhost: {}\r\n\r\n", server.address);
    let own_line = format!("http://{}/scans", server.address);
    for (uri, status) in [("http://evil.example/scans", 403), (own_line.as_str(), 200)] {
        assert_eq!(server.client().raw(line(uri).as_bytes()).unwrap().status, status, "{uri}");
    }
    let mut client = server.client();
    let other = client.raw(b"GET /scans HTTP/1.1\r\nhost: evil.example\r\n\r\n").unwrap();
    assert_eq!((other.status, other.message().contains("evil.example")), (403, true));
    let (status, head) = status(&server, "GET", "/", "sec-fetch-site: none\r\n");
    assert_eq!(status, 200);
    for part in ["default-src 'none'", "nosniff", "no-referrer"] {
        assert!(head.contains(part), "{head}");
    }
    assert!(!head.contains("access-control"), "{head}");
}

#[test]
fn a_chosen_token_is_asked_of_everybody() {
    let folder = Folder::new("token");
    let token = "correct-horse-battery";
    let server = Server::with_token(&folder.path("scans"), token);
    let of = |headers: &str| status(&server, "GET", "/scans", headers).0;
    assert_eq!(of(""), 401);
    assert_eq!(of(&format!("authorization: Bearer {token}\r\n")), 200);
    assert_eq!(of(&format!("authorization: Bearer {token}x\r\n")), 401);
    assert_eq!(status(&server, "GET", "/healthz", "").0, 200);
}

#[test]
fn every_route_is_described() {
    let folder = Folder::new("described");
    let server = Server::start(&folder.path("scans"));
    let description = Client::new(server.address).get("/openapi.json").expect(200);
    let paths = description["paths"].as_object().unwrap();
    for (path, operations) in paths {
        for method in operations.as_object().unwrap().keys().filter(|key| *key != "parameters") {
            let path = path.replace("{id}", "none").replace("{name}", "map.ot").replace("{step}", "1");
            let (status, _) = status(&server, &method.to_uppercase(), &path, "");
            assert_ne!(status, 405, "{method} {path}");
        }
    }
    let refs = description.to_string();
    let names = refs.split("\"#/components/").skip(1).map(|rest| rest.split('"').next().unwrap());
    for name in names {
        let found = description.pointer(&format!("/components/{name}"));
        assert!(found.is_some_and(Value::is_object), "{name} is described nowhere");
    }
}

#[test]
fn without_a_token_it_listens_on_loopback_only() {
    use nextview_server::{ServerConfig, serve};
    let config = ServerConfig { listen: "0.0.0.0:0".parse().unwrap(), ..ServerConfig::default() };
    let fault = serve(config, |_| panic!("it must not start")).unwrap_err().to_string();
    assert!(fault.contains("`listen` is 0.0.0.0:0, expected a loopback address"), "{fault}");
}
