/// Implements serde's traits for a type with the attribute `serde(remote = "Self")` and checks every
/// deserialized value with the type's method `check`.
macro_rules! checked_when_read {
    ($type:ty) => {
        impl ::serde::Serialize for $type {
            fn serialize<S: ::serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                <$type>::serialize(self, serializer)
            }
        }

        impl<'de> ::serde::Deserialize<'de> for $type {
            fn deserialize<D: ::serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                let value = <$type>::deserialize(deserializer)?;
                value.check().map_err(::serde::de::Error::custom)?;
                Ok(value)
            }
        }
    };
}

pub(crate) use checked_when_read;

/// Fails unless the value is in the range that `expected` describes.
pub(crate) fn check_range(
    name: &'static str,
    value: f64,
    range: std::ops::RangeInclusive<f64>,
    expected: &'static str,
) -> Result<(), crate::Error> {
    if range.contains(&value) {
        return Ok(());
    }
    Err(crate::Error::invalid(name, value, expected))
}
