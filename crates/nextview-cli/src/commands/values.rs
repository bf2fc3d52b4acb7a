//! Parsers of values on the command line.

use clap::builder::{OsStringValueParser, PossibleValue, PossibleValuesParser, TypedValueParser};
use glam::DVec3;
use nextview::geometry::Aabb;
use nextview_campaign::Shard;
use nextview_scan::{Fault, Named};
use serde::de::DeserializeOwned;
use std::ffi::OsString;

/// A value by name.
pub(super) fn named<T: Named + Send + Sync>() -> impl TypedValueParser<Value = T> {
    some_named(|_: T| true)
}

/// One of the suitable values, by name.
pub(super) fn some_named<T: Named + Send + Sync>(
    is_suitable: fn(T) -> bool,
) -> impl TypedValueParser<Value = T> {
    let values = T::ALL.iter().filter(|value| is_suitable(**value));
    let values = values.map(|value| PossibleValue::new(value.name()).help(value.about()));
    PossibleValuesParser::new(values)
        .map(|name| T::of_name(&name).expect("the parser knows all names and no other"))
}

/// One of the words for values in configurations.
pub(super) fn word<T: DeserializeOwned>(text: &str) -> Result<T, String> {
    serde_json::from_value(text.into()).map_err(|error| error.to_string())
}

/// A shard, such as 3/64.
pub(super) fn shard(text: &str) -> Result<Shard, String> {
    text.parse().map_err(|fault: Fault| fault.expected.map_or(fault.message, |it| format!("expected {it}")))
}

/// The name of a file; it must be text, as in configurations and results.
pub(super) fn file_name() -> impl TypedValueParser<Value = String> {
    let text = |name: OsString| name.into_string().map_err(|_| "the name is not Unicode: rename the file");
    OsStringValueParser::new().try_map(text)
}

/// A finite number.
pub(super) fn number(text: &str) -> Result<f64, String> {
    let value: f64 = text.trim().parse().map_err(|_| format!("'{text}' is not a number"))?;
    if value.is_finite() { Ok(value) } else { Err(format!("{text} is not finite")) }
}

/// A positive, finite number.
pub(super) fn positive(text: &str) -> Result<f64, String> {
    let value = number(text)?;
    if value > 0.0 { Ok(value) } else { Err(format!("{text} is not positive")) }
}

/// A finite number, at least 0.
pub(super) fn not_negative(text: &str) -> Result<f64, String> {
    let value = number(text)?;
    if value >= 0.0 { Ok(value) } else { Err(format!("{text} is negative")) }
}

/// A number from 0 to 1.
pub(super) fn share(text: &str) -> Result<f64, String> {
    let value = number(text)?;
    if (0.0..=1.0).contains(&value) { Ok(value) } else { Err(format!("{text} is not between 0 and 1")) }
}

/// A whole number, at least 0.
pub(super) fn count(text: &str) -> Result<usize, String> {
    text.parse().map_err(|_| format!("'{text}' is not a whole number of at least 0"))
}

/// A seed: up to 2^63 - 1, the largest integer in a TOML file.
pub(super) fn seed(text: &str) -> Result<u64, String> {
    let value: i64 =
        text.parse().map_err(|_| format!("'{text}' is not a whole number from 0 to {}", i64::MAX))?;
    u64::try_from(value).map_err(|_| format!("{text} is negative"))
}

/// Three numbers, `x,y,z`.
pub(super) fn point(text: &str) -> Result<DVec3, String> {
    numbers::<3>(text, "x,y,z").map(DVec3::from_array)
}

/// A cube, `cx,cy,cz,half`: its centre and half its edge.
pub(super) fn cube(text: &str) -> Result<Aabb, String> {
    let [x, y, z, half] = numbers::<4>(text, "cx,cy,cz,half")?;
    if half <= 0.0 {
        return Err(format!("half the edge is {half}, expected a positive number of metres"));
    }
    Ok(Aabb::cube(DVec3::new(x, y, z), half))
}

/// A sphere, `x,y,z,r`: its centre and its radius.
pub(super) fn sphere(text: &str) -> Result<[f64; 4], String> {
    let sphere = numbers::<4>(text, "x,y,z,r")?;
    match sphere[3] {
        radius if radius > 0.0 => Ok(sphere),
        radius => Err(format!("the radius is {radius}, expected a positive number of metres")),
    }
}

/// A box, `x0,y0,z0,x1,y1,z1`: its lowest and its highest corner.
pub(super) fn corners(text: &str) -> Result<[f64; 6], String> {
    numbers::<6>(text, "x0,y0,z0,x1,y1,z1")
}

fn numbers<const N: usize>(text: &str, form: &str) -> Result<[f64; N], String> {
    let values: Vec<f64> = text.split(',').map(number).collect::<Result<_, _>>()?;
    let n = values.len();
    values.try_into().map_err(|_| format!("{n} numbers, expected {N}: {form}"))
}
