//! Enums with named values.

use crate::Fault;

/// A type with named values.
pub trait Named: Copy + PartialEq + Sized + 'static {
    /// All values in listing order.
    const ALL: &'static [Self];

    /// The name, in kebab case.
    fn name(self) -> &'static str;

    /// A one-line description.
    fn about(self) -> &'static str;

    /// Returns the value of this name.
    fn of_name(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|value| value.name() == name)
    }

    /// Returns the value of this name for a key; the fault lists all names.
    fn of_key(key: &str, name: &str) -> Result<Self, Fault> {
        let names = || Self::ALL.iter().map(|value| value.name()).collect::<Vec<_>>().join(", ");
        Self::of_name(name).ok_or_else(|| Fault::of_value(key, name, format!("one of {}", names())))
    }
}

/// Declares an enum with a name and a description for each value, for serde, [`Named`] and `Display`.
macro_rules! named {
    ($(#[$meta:meta])* pub enum $type:ident { $($(#[$attribute:meta])* $value:ident = $name:literal: $about:literal,)+ }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
        #[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
        pub enum $type {
            $(#[doc = $about] $(#[$attribute])* #[serde(rename = $name)] $value,)+
        }

        impl $crate::Named for $type {
            const ALL: &'static [Self] = &[$(Self::$value),+];

            fn name(self) -> &'static str {
                match self { $(Self::$value => $name),+ }
            }

            fn about(self) -> &'static str {
                match self { $(Self::$value => $about),+ }
            }
        }

        impl std::fmt::Display for $type {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.pad($crate::Named::name(*self))
            }
        }
    };
}
pub(crate) use named;
