use super::about::About;
use crate::Limits;
use crate::access::random_hex;
use crate::json::json;
use crate::limits::exceeded;
use crate::refusal::Refusal;
use axum::http::StatusCode;
use nextview_scan::{Fault, Faults, ScanConfig};
use serde_json::{Map, Value};

/// A scan that is asked for.
#[derive(Debug)]
pub(crate) struct NewScan {
    /// Its name, which is the object's as well where the request has none.
    pub id: String,
    pub confirm_views: bool,
    /// The id of the scan that it continues.
    pub after: Option<String>,
    /// Of its configuration, those that were given.
    keys: toml::Table,
}

/// Largest configuration, bytes, as of a file.
const MAX_BYTES: usize = 1 << 20;

impl NewScan {
    /// From a JSON object with the keys of a configuration, an optional `id`, which is made where it is
    /// missing, `confirm_views` and `after`.
    pub fn from_json(bytes: &[u8]) -> Result<Self, Refusal> {
        if bytes.len() > MAX_BYTES {
            let fault = exceeded("content-length", bytes.len(), format!("{MAX_BYTES} bytes"));
            return Err(Refusal::new(StatusCode::PAYLOAD_TOO_LARGE, fault));
        }
        let mut keys: Map<String, Value> = json(bytes, "the scan")?;
        let mut faults = Vec::new();
        let id = take(&mut keys, "id", &mut faults, |value| {
            value.as_str().filter(|id| is_id(id)).map(str::to_owned)
        });
        let confirm_views = take(&mut keys, "confirm_views", &mut faults, Value::as_bool);
        let after = take(&mut keys, "after", &mut faults, |value| value.as_str().map(str::to_owned));
        let keys = table(keys)?;
        faults.extend(ScanConfig::faults_of_request(&keys));
        Faults::of(faults).map_or(Ok(()), |faults| Err(Refusal::content(faults)))?;
        let id = id.map_or_else(|| Ok(format!("scan-{}", random_hex(6)?)), Ok::<_, Fault>)?;
        Ok(Self { id, confirm_views: confirm_views.unwrap_or(false), after, keys })
    }

    /// Its configuration: where it continues a scan, keys that were not given are those of that scan's.
    pub fn config(&self, before: Option<ScanConfig>, limits: &Limits) -> Result<ScanConfig, Refusal> {
        let before = before.map(toml::Table::try_from).transpose().map_err(Fault::data)?;
        let mut table = before.unwrap_or_default();
        table.extend(self.keys.clone());
        table.entry("object").or_insert_with(|| self.id.clone().into());
        let config = ScanConfig::from_table(table).map_err(Refusal::content)?;
        let faults = too_much(&config, limits);
        Faults::of(faults).map_or(Ok(config), |faults| Err(Refusal::content(faults)))
    }
}

/// Whether this is a name of a scan: it is one of a folder, too.
fn is_id(id: &str) -> bool {
    let is_letter = |byte: u8| byte.is_ascii_lowercase() || byte.is_ascii_digit();
    id.len() <= 64
        && id.bytes().next().is_some_and(is_letter)
        && id.bytes().all(|byte| is_letter(byte) || b"-_".contains(&byte))
}

/// The value of a key that is the server's own.
fn take<T>(
    keys: &mut Map<String, Value>,
    key: &str,
    faults: &mut Vec<Fault>,
    read: impl FnOnce(&Value) -> Option<T>,
) -> Option<T> {
    let value = keys.remove(key).filter(|value| !value.is_null())?;
    let read = read(&value);
    if read.is_none() {
        let expected = match key {
            "after" => "the id of a finished scan",
            "id" => "1 to 64 of a-z, 0-9, - and _, the first a letter or a digit",
            _ => "true or false",
        };
        faults.push(Fault::of_value(key, value, expected));
    }
    read
}

/// The same keys as a configuration file has; those without a value are left out.
fn table(keys: Map<String, Value>) -> Result<toml::Table, Refusal> {
    let mut value = Value::Object(keys);
    drop_null(&mut value);
    let table = toml::Table::try_from(value);
    table.map_err(|error| Refusal::content(Fault::request(format!("the scan: {error}"))))
}

fn drop_null(value: &mut Value) {
    match value {
        Value::Object(keys) => {
            keys.retain(|_, value| !value.is_null());
            keys.values_mut().for_each(drop_null);
        }
        Value::Array(values) => values.iter_mut().for_each(drop_null),
        _ => (),
    }
}

/// What the server does not take on.
fn too_much(config: &ScanConfig, limits: &Limits) -> Vec<Fault> {
    let mut faults = Vec::new();
    if config.live.is_none() {
        let fault =
            Fault::request("`live` is missing, which says where the object is and what the camera measures");
        let fault = fault.with_remedy("state `live.box_m`, or `live.first_pose`");
        faults.push(Fault { key: Some("live".to_owned()), ..fault });
    }
    let poses = config.live.as_ref().map_or(0, |live| live.poses.len());
    let counts = [
        ("candidates", config.candidates, limits.candidates),
        ("live.poses", poses, limits.candidates),
        ("views", config.views.unwrap_or(0), limits.frames),
        ("camera", config.camera.n_pixels(), limits.image_pixels),
        ("memory_limit_mb", config.memory_limit_mb as usize, limits.memory_mb as usize),
    ];
    let exceeding = counts.into_iter().filter(|(_, value, most)| value > most);
    faults.extend(exceeding.map(|(key, value, most)| match key {
        "camera" => exceeded(key, format!("{value} pixels"), format!("{most} pixels")),
        _ => exceeded(key, value, most),
    }));
    faults
}

#[cfg(test)]
mod tests {
    use super::*;

    fn new_scan(keys: Value) -> Result<(String, ScanConfig), String> {
        let mut body = serde_json::json!({ "live": { "box_m": [0, 0, 0, 0.1, 0.1, 0.1] } });
        body.as_object_mut().unwrap().extend(keys.as_object().unwrap().clone());
        let new = NewScan::from_json(body.to_string().as_bytes());
        let made = new.and_then(|new| Ok((new.id.clone(), new.config(None, &Limits::default())?)));
        made.map_err(|refusal| format!("{refusal:?}"))
    }

    #[test]
    fn an_object_without_a_name_has_that_of_the_scan() {
        let object = |keys| new_scan(keys).map(|(id, config)| (id, config.object)).unwrap();
        let (id, named) = object(serde_json::json!({ "id": "valve" }));
        assert_eq!((id.as_str(), named.as_str()), ("valve", "valve"));
        assert_eq!(object(serde_json::json!({ "id": "valve", "object": "pump" })).1, "pump");
        let (id, named) = object(serde_json::json!({}));
        assert!(id.starts_with("scan-") && id == named, "{id}, {named}");
    }

    #[test]
    fn no_file_of_the_server_is_advised() {
        let refused = new_scan(serde_json::json!({ "sensor": "d4" })).unwrap_err();
        let expected = "`sensor` is d4, expected one of d405";
        assert!(refused.contains(expected) && !refused.contains(".toml"), "{refused}");
    }
}
