use crate::refusal::Refusal;
use axum::http::StatusCode;
use nextview_scan::Fault;
use serde::de::DeserializeOwned;

/// Parses a JSON text.
pub(crate) fn json<T: DeserializeOwned>(bytes: &[u8], what: &str) -> Result<T, Refusal> {
    let mut reader = serde_json::Deserializer::from_slice(bytes);
    let value = serde_path_to_error::deserialize(&mut reader).map_err(|error| {
        let (path, inner) = (error.path().to_string(), error.inner());
        let status = if inner.is_data() { StatusCode::UNPROCESSABLE_ENTITY } else { StatusCode::BAD_REQUEST };
        let key = (path != "." && inner.is_data()).then_some(path);
        let place = key.as_ref().map(|key| format!("`{key}`: ")).unwrap_or_default();
        Refusal::new(status, Fault { key, ..Fault::request(format!("{what}: {place}{inner}")) })
    })?;
    reader.end().map_err(|error| Refusal::of(StatusCode::BAD_REQUEST, format!("{what}: {error}")))?;
    Ok(value)
}
