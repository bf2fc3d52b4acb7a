//! Reads a configuration whose source is one of several keys.
//!
//! serde's `flatten` would do that, but reads values without their places, and unknown keys without the known
//! ones.

use super::{ScanConfig, SourceConfig};
use serde::de::{self, Deserialize, DeserializeSeed, Deserializer, IntoDeserializer, MapAccess, Visitor};
use std::fmt;
use std::sync::OnceLock;

impl<'de> Deserialize<'de> for ScanConfig {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let mut source = SourceConfig::Simulated;
        let config = Self::deserialize(Apart { inner: deserializer, source: &mut source })?;
        Ok(Self { source, ..config })
    }
}

/// A deserializer, or a visitor or map and all keys: the source is read apart from the other keys.
struct Apart<'s, T> {
    inner: T,
    source: &'s mut SourceConfig,
}

impl<'de, D: Deserializer<'de>> Deserializer<'de> for Apart<'_, D> {
    type Error = D::Error;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, D::Error> {
        self.inner.deserialize_any(visitor)
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        name: &'static str,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, D::Error> {
        static KEYS: OnceLock<Vec<&'static str>> = OnceLock::new();
        let keys = KEYS.get_or_init(|| fields.iter().copied().chain(["recording", "live"]).collect());
        let inner = (visitor, keys.as_slice());
        self.inner.deserialize_struct(name, keys, Apart { inner, source: self.source })
    }

    serde::forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf option unit
        unit_struct newtype_struct seq tuple tuple_struct map enum identifier ignored_any
    }
}

impl<'de, V: Visitor<'de>> Visitor<'de> for Apart<'_, (V, &'static [&'static str])> {
    type Value = V::Value;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.inner.0.expecting(f)
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<V::Value, A::Error> {
        let (visitor, keys) = self.inner;
        visitor.visit_map(Apart { inner: (map, keys), source: self.source })
    }
}

impl<'de, A: MapAccess<'de>> MapAccess<'de> for Apart<'_, (A, &'static [&'static str])> {
    type Error = A::Error;

    fn next_key_seed<K: DeserializeSeed<'de>>(&mut self, seed: K) -> Result<Option<K::Value>, A::Error> {
        let (map, keys) = &mut self.inner;
        while let Some(key) = map.next_key::<String>()? {
            let source = match key.as_str() {
                "recording" => map.next_value::<Option<_>>()?.map(SourceConfig::Recording),
                "live" => map.next_value::<Option<_>>()?.map(SourceConfig::Live),
                known if keys.contains(&known) => return seed.deserialize(key.into_deserializer()).map(Some),
                unknown => return Err(de::Error::unknown_field(unknown, keys)),
            };
            match (source, self.source.is_simulated()) {
                (Some(_), false) => return Err(de::Error::custom(SourceConfig::two())),
                (Some(source), true) => *self.source = source,
                (None, _) => (),
            }
        }
        Ok(None)
    }

    fn next_value_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<T::Value, A::Error> {
        self.inner.0.next_value_seed(seed)
    }
}
