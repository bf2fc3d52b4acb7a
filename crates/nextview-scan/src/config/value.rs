//! Converts TOML values to types; a mismatch is reported as data: its place and the expected value.

use crate::{Fault, FaultKind};
use serde::de::value::MapAccessDeserializer;
use serde::de::{
    self, DeserializeOwned, DeserializeSeed, Deserializer, Expected, IntoDeserializer, MapAccess, SeqAccess,
    Unexpected, Visitor,
};
use std::fmt;
use std::iter::Enumerate;
use std::marker::PhantomData;
use std::slice;
use toml::Value;
use toml::map::Iter;

/// Reads the value of a key.
pub fn read_value<T: DeserializeOwned>(key: &str, value: &Value) -> Result<T, Fault> {
    read(value).map_err(|problem| problem.under(key).fault())
}

/// Reads a value.
pub(super) fn read<T: DeserializeOwned>(value: &Value) -> Result<T, Mismatch> {
    read_by(PhantomData, value)
}

fn read_by<'de, T: DeserializeSeed<'de>>(seed: T, value: &Value) -> Result<T::Value, Mismatch> {
    seed.deserialize(OpenValue(value)).map_err(|problem| problem.of(value))
}

/// The first mismatch.
#[derive(Clone, Debug)]
pub(super) struct Mismatch {
    /// Path of keys and list indices to the mismatch, innermost first.
    path: Vec<String>,
    pub what: What,
}

#[derive(Clone, Debug)]
pub(super) enum What {
    /// The last part of the path is not a key; these are the valid ones.
    Unknown(&'static [&'static str]),
    /// The last part of the path is a required key that is missing.
    Missing,
    /// The value has the wrong type or is out of range.
    Unfit { value: Option<String>, expected: String },
    /// An error in the type's own words.
    Other(String),
}

impl Mismatch {
    fn new(what: What) -> Self {
        Self { path: Vec::new(), what }
    }

    fn unfit(expected: impl Into<String>) -> Self {
        Self::new(What::Unfit { value: None, expected: expected.into() })
    }

    /// Adds an outer level to the path.
    fn under(mut self, key: impl Into<String>) -> Self {
        self.path.push(key.into());
        self
    }

    /// Sets the mismatched value, unless the problem already has a deeper one.
    fn of(mut self, unfit: &Value) -> Self {
        if let What::Unfit { value: value @ None, .. } = &mut self.what
            && self.path.is_empty()
        {
            *value = Some(shown(unfit));
        }
        self
    }

    /// The path as a dotted key.
    pub fn key(&self) -> String {
        dotted(&self.path)
    }

    /// The dotted key of the table that contains the mismatch.
    pub fn parent(&self) -> String {
        dotted(self.path.get(1..).unwrap_or_default())
    }

    /// The problem as a fault, with the nearest known key for an unknown one.
    pub fn fault(&self) -> Fault {
        let key = self.key();
        match &self.what {
            What::Unknown(known) => {
                let word = self.path.first().map_or("", String::as_str);
                let prefix = key.strip_suffix(word).unwrap_or_default();
                Fault::unknown_key(prefix, word, known.iter().copied())
            }
            What::Missing => Fault { key: Some(key.clone()), ..Fault::data(format!("`{key}` is missing")) },
            What::Unfit { value, expected } => {
                let value = value.as_deref().unwrap_or("something else");
                Fault { kind: FaultKind::Data, ..Fault::of_value(&key, value, expected) }
            }
            What::Other(message) => {
                Fault { key: Some(key.clone()), ..Fault::data(format!("`{key}`: {message}")) }
            }
        }
    }
}

/// Joins the keys of a path, innermost first, into a dotted key.
fn dotted(path: &[String]) -> String {
    path.iter().rev().map(String::as_str).collect::<Vec<_>>().join(".")
}

impl fmt::Display for Mismatch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.fault().fmt(f)
    }
}

impl std::error::Error for Mismatch {}

impl de::Error for Mismatch {
    fn custom<T: fmt::Display>(message: T) -> Self {
        Self::new(What::Other(message.to_string()))
    }

    fn invalid_type(_: Unexpected<'_>, expected: &dyn Expected) -> Self {
        Self::unfit(in_words(expected))
    }

    fn invalid_value(_: Unexpected<'_>, expected: &dyn Expected) -> Self {
        Self::unfit(in_words(expected))
    }

    fn invalid_length(_: usize, expected: &dyn Expected) -> Self {
        Self::unfit(in_words(expected))
    }

    fn unknown_variant(_: &str, expected: &'static [&'static str]) -> Self {
        Self::unfit(match expected {
            [only] => (*only).to_owned(),
            [one, other] => format!("{one} or {other}"),
            names => format!("one of {}", names.join(", ")),
        })
    }

    fn unknown_field(field: &str, expected: &'static [&'static str]) -> Self {
        Self::new(What::Unknown(expected)).under(field)
    }

    fn missing_field(field: &'static str) -> Self {
        Self::new(What::Missing).under(field)
    }
}

/// Describes an expected value to users: serde gives only the name of a Rust type.
fn in_words(expected: &dyn Expected) -> String {
    let expected = expected.to_string();
    match expected.as_str() {
        "u8" => format!("a whole number, 0 to {}", u8::MAX),
        "u16" => format!("a whole number, 0 to {}", u16::MAX),
        "u32" => format!("a whole number, 0 to {}", u32::MAX),
        "u64" | "usize" => "a whole number, at least 0".to_owned(),
        "f32" | "f64" => "a number".to_owned(),
        "a boolean" => "true or false".to_owned(),
        "a sequence" => "a list".to_owned(),
        "a map" => "a table".to_owned(),
        "path string" => "a path".to_owned(),
        "unit" | "unit variant" => "the name alone".to_owned(),
        name if name.ends_with(" variant") => "a table with the name as its key".to_owned(),
        name if name.starts_with("struct ") => "a table".to_owned(),
        name if name.starts_with("tuple struct ") => "a list of numbers".to_owned(),
        name => match name.strip_prefix("an array of length ") {
            Some(n) => format!("a list of {n}"),
            None => expected,
        },
    }
}

/// Maximum length of a value in a message, in characters.
const MOST_SHOWN: usize = 80;

/// Formats a value for a message, truncated if long.
fn shown(value: &Value) -> String {
    let text = value.to_string();
    match text.char_indices().nth(MOST_SHOWN) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text,
    }
}

/// A value being read.
struct OpenValue<'a>(&'a Value);

impl<'de> Deserializer<'de> for OpenValue<'_> {
    type Error = Mismatch;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Mismatch> {
        match self.0 {
            Value::String(text) => visitor.visit_str(text),
            Value::Integer(number) => visitor.visit_i64(*number),
            Value::Float(number) => visitor.visit_f64(*number),
            Value::Boolean(truth) => visitor.visit_bool(*truth),
            Value::Datetime(_) => Err(de::Error::invalid_type(Unexpected::Other("date"), &visitor)),
            Value::Array(values) => {
                let mut list = ValueList(values.iter().enumerate());
                visitor.visit_seq(&mut list).and_then(|read| match list.0.len() {
                    0 => Ok(read),
                    left => Err(Mismatch::unfit(format!("a list of {}", values.len() - left))),
                })
            }
            Value::Table(table) => visitor.visit_map(Keys { entries: table.iter(), open: None }),
        }
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Mismatch> {
        visitor.visit_some(self)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, Mismatch> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        names: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Mismatch> {
        match self.0 {
            Value::String(name) => visitor.visit_enum(name.as_str().into_deserializer()),
            Value::Table(table) if table.len() == 1 => {
                let keys = Keys { entries: table.iter(), open: None };
                visitor.visit_enum(MapAccessDeserializer::new(keys))
            }
            _ => Err(de::Error::unknown_variant("", names)),
        }
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Mismatch> {
        match self.0 {
            // A struct could be read from a list of its fields, but no configuration is written that way.
            Value::Array(_) => Err(de::Error::invalid_type(Unexpected::Seq, &visitor)),
            _ => self.deserialize_any(visitor),
        }
    }

    serde::forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf unit unit_struct
        seq tuple tuple_struct map identifier ignored_any
    }
}

struct ValueList<'a>(Enumerate<slice::Iter<'a, Value>>);

impl<'de> SeqAccess<'de> for &mut ValueList<'_> {
    type Error = Mismatch;

    fn next_element_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<Option<T::Value>, Mismatch> {
        let Some((place, value)) = self.0.next() else { return Ok(None) };
        read_by(seed, value).map(Some).map_err(|problem| problem.under(place.to_string()))
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.0.len())
    }
}

struct Keys<'a> {
    entries: Iter<'a, String, Value>,
    /// The key read last, and its value.
    open: Option<(&'a String, &'a Value)>,
}

impl<'de> MapAccess<'de> for Keys<'_> {
    type Error = Mismatch;

    fn next_key_seed<K: DeserializeSeed<'de>>(&mut self, seed: K) -> Result<Option<K::Value>, Mismatch> {
        self.open = self.entries.next();
        self.open.map(|(key, _)| seed.deserialize(key.as_str().into_deserializer())).transpose()
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, Mismatch> {
        let (key, value) = self.open.take().expect("a key comes before its value");
        read_by(seed, value).map_err(|problem| problem.under(key))
    }
}
