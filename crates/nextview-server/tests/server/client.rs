//! A small HTTP client.

use serde_json::Value;
use std::io::{BufRead, BufReader, ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::time::Duration;

/// An answer.
#[derive(Debug)]
pub struct Answer {
    pub status: u16,
    pub head: String,
    pub body: Vec<u8>,
}

impl Answer {
    pub fn json(&self) -> Value {
        serde_json::from_slice(&self.body).unwrap_or_else(|e| panic!("{e}: {self:?}"))
    }

    /// Returns the body; the answer must have this status.
    pub fn expect(self, status: u16) -> Value {
        assert_eq!(self.status, status, "{} {}", self.head, String::from_utf8_lossy(&self.body));
        self.json()
    }

    /// The message of the first fault.
    pub fn message(&self) -> String {
        self.json()["faults"][0]["message"].as_str().unwrap_or_default().to_owned()
    }
}

/// A connection that stays open.
pub struct Client {
    address: SocketAddr,
    stream: BufReader<TcpStream>,
    headers: String,
}

impl Client {
    pub fn new(address: SocketAddr) -> Self {
        Self::try_new(address).unwrap()
    }

    pub fn try_new(address: SocketAddr) -> std::io::Result<Self> {
        let stream = TcpStream::connect(address)?;
        stream.set_nodelay(true)?;
        stream.set_read_timeout(Some(Duration::from_secs(60)))?;
        Ok(Self { address, stream: BufReader::new(stream), headers: String::new() })
    }

    /// Adds these lines to every head.
    pub fn with_headers(self, headers: &str) -> Self {
        Self { headers: headers.to_owned(), ..self }
    }

    /// The host that requests name.
    pub fn host(&self) -> SocketAddr {
        self.address
    }

    pub fn get(&mut self, path: &str) -> Answer {
        self.send("GET", path, "", b"").unwrap()
    }

    pub fn post(&mut self, path: &str, json: &Value) -> Answer {
        self.send("POST", path, "application/json", json.to_string().as_bytes()).unwrap()
    }

    pub fn delete(&mut self, path: &str) -> Answer {
        self.send("DELETE", path, "", b"").unwrap()
    }

    pub fn send(&mut self, method: &str, path: &str, kind: &str, body: &[u8]) -> std::io::Result<Answer> {
        let mut head = format!("{method} {path} HTTP/1.1\r\nhost: {}\r\n{}", self.address, self.headers);
        if !kind.is_empty() {
            head += &format!("content-type: {kind}\r\n");
        }
        head += &format!("content-length: {}\r\n\r\n", body.len());
        self.raw(&[head.as_bytes(), body].concat())
    }

    /// Sends these bytes and reads an answer.
    pub fn raw(&mut self, bytes: &[u8]) -> std::io::Result<Answer> {
        let sent = self.stream.get_mut().write_all(bytes);
        // A server that refuses a body may not read all of it.
        self.answer().or_else(|error| sent.and(Err(error)))
    }

    pub fn write(&mut self, bytes: &[u8]) -> std::io::Result<()> {
        self.stream.get_mut().write_all(bytes)
    }

    pub fn answer(&mut self) -> std::io::Result<Answer> {
        let mut head = String::new();
        while !head.ends_with("\r\n\r\n") {
            if self.stream.read_line(&mut head)? == 0 {
                return Err(ErrorKind::UnexpectedEof.into());
            }
        }
        let status = head.split(' ').nth(1).and_then(|status| status.parse().ok());
        let status = status.ok_or(ErrorKind::InvalidData)?;
        let length = head.lines().find_map(|line| line.strip_prefix("content-length: ")?.parse().ok());
        let mut body = vec![0; length.unwrap_or(0)];
        self.stream.read_exact(&mut body)?;
        Ok(Answer { status, head, body })
    }

    /// A line of an answer without an end.
    pub fn line(&mut self) -> std::io::Result<String> {
        let mut line = String::new();
        self.stream.read_line(&mut line)?;
        Ok(line.trim_end().to_owned())
    }
}
