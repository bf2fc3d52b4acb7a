use std::net::{IpAddr, SocketAddr};

/// Names of the server. A foreign page whose name resolves to this address (DNS rebinding) requests another
/// name.
pub(crate) struct Hosts {
    address: SocketAddr,
    /// Additional names, with any port: a proxy has another one.
    names: Vec<String>,
}

impl Hosts {
    pub fn new(address: SocketAddr, names: Vec<String>) -> Self {
        Self { address, names: names.into_iter().map(|name| name.to_ascii_lowercase()).collect() }
    }

    /// Whether a request for this host is for this server.
    pub fn has(&self, host: &str) -> bool {
        let host = host.to_ascii_lowercase();
        let (name, port) = match host.rsplit_once(':') {
            Some((name, port)) if !port.is_empty() && port.bytes().all(|b| b.is_ascii_digit()) => {
                (name, port)
            }
            _ => (&*host, "80"),
        };
        if self.names.iter().any(|own| own == name) {
            return true;
        }
        let address = name.trim_start_matches('[').trim_end_matches(']').parse::<IpAddr>();
        let is_name = match address {
            // For a server that listens on all addresses: unlike a name, an address cannot be redirected here
            // by others.
            Ok(ip) => ip == self.address.ip() || self.address.ip().is_unspecified(),
            Err(_) => {
                name == "localhost" && (self.address.ip().is_loopback() || self.address.ip().is_unspecified())
            }
        };
        is_name && port.parse() == Ok(self.address.port())
    }

    /// The names, for a message.
    pub fn expected(&self) -> String {
        let address = self.address.to_string();
        let all = std::iter::once(&address).chain(&self.names);
        all.map(String::as_str).collect::<Vec<_>>().join(", ")
    }
}

#[cfg(test)]
mod tests {
    use super::Hosts;

    #[test]
    fn only_own_names_count() {
        let hosts = |address: &str| Hosts::new(address.parse().unwrap(), vec!["Scanner.local".to_owned()]);
        let local = hosts("127.0.0.1:7878");
        for (host, expected) in [
            ("127.0.0.1:7878", true),
            ("localhost:7878", true),
            ("LOCALHOST:7878", true),
            ("scanner.local", true),
            ("scanner.local:443", true),
            ("127.0.0.1", false),
            ("127.0.0.1:7879", false),
            ("127.0.0.1.evil.example:7878", false),
            ("evil.example:7878", false),
            ("192.168.0.3:7878", false),
            ("", false),
        ] {
            assert_eq!(local.has(host), expected, "{host}");
        }
        let open = hosts("0.0.0.0:7878");
        assert!(open.has("192.168.0.3:7878") && !open.has("evil.example:7878"));
        assert!(hosts("[::1]:7878").has("[::1]:7878"));
    }
}
