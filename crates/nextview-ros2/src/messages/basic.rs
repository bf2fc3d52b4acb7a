use serde::de::{Error, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;

/// `builtin_interfaces/msg/Time`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Time {
    pub sec: i32,
    pub nanosec: u32,
}

impl Time {
    pub fn seconds(self) -> f64 {
        self.sec as f64 + 1e-9 * self.nanosec as f64
    }

    /// Converts from a non-negative time in seconds.
    pub fn from_seconds(seconds: f64) -> Self {
        let whole = seconds.floor();
        // A nanosecond less than a second may round up to one.
        let nanosec = (1e9 * (seconds - whole)).round().min(999_999_999.0);
        Self { sec: whole as i32, nanosec: nanosec as u32 }
    }
}

/// `std_msgs/msg/Header`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Header {
    pub stamp: Time,
    pub frame_id: String,
}

impl Header {
    /// For content valid at any time in this frame: time 0, which transforms interpret as the latest.
    pub fn of(frame: &str) -> Self {
        Self { stamp: Time::default(), frame_id: frame.to_owned() }
    }
}

/// `std_msgs/msg/String`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Text {
    pub data: String,
}

/// A list of bytes, read and written as a whole: one by one, an image would take a thousand times as long.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Bytes(pub Vec<u8>);

impl Serialize for Bytes {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_bytes(&self.0)
    }
}

impl<'de> Deserialize<'de> for Bytes {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Copied;
        impl Visitor<'_> for Copied {
            type Value = Bytes;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("bytes")
            }

            fn visit_byte_buf<E: Error>(self, bytes: Vec<u8>) -> Result<Bytes, E> {
                Ok(Bytes(bytes))
            }

            fn visit_bytes<E: Error>(self, bytes: &[u8]) -> Result<Bytes, E> {
                Ok(Bytes(bytes.to_vec()))
            }
        }
        deserializer.deserialize_byte_buf(Copied)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_seconds_and_nanoseconds() {
        let time = Time { sec: 1_700_000_000, nanosec: 250_000_000 };
        assert_eq!(time.seconds(), 1_700_000_000.25);
        assert_eq!(Time::from_seconds(3.25), Time { sec: 3, nanosec: 250_000_000 });
        assert_eq!(Time::from_seconds(1.0 - 1e-12), Time { sec: 0, nanosec: 999_999_999 });
    }
}
