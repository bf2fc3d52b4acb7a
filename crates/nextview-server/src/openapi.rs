use crate::refusal::FaultsAnswer;
use crate::routes::{Content, Doc, Operation, Route, routes};
use schemars::SchemaGenerator;
use schemars::generate::SchemaSettings;
use serde_json::{Map, Value, json};

/// Statuses of refusals with their meaning.
const REFUSALS: [(&str, &str); 10] = [
    ("400", "the request is malformed"),
    ("401", "a token is missing or wrong"),
    ("403", "the request is for another host, or from a page of another one"),
    ("404", "there is no such scan, file or step"),
    ("409", "the state of the scan does not allow it"),
    ("413", "the body is too large"),
    ("415", "the content type is not supported"),
    ("422", "a value is invalid"),
    ("429", "too many requests to this scan are already waiting"),
    ("503", "a limit of the server is reached"),
];

/// Describes all routes: OpenAPI 3.1, with the schemas of all types in requests and answers.
pub fn openapi() -> Value {
    let settings = SchemaSettings::draft2020_12().with(|settings| {
        settings.definitions_path = "/components/schemas".into();
        settings.meta_schema = None;
    });
    let mut generator = settings.into_generator();
    let mut paths = Map::new();
    for route in routes() {
        paths.insert(route.path.to_owned(), path(&route, &mut generator));
    }
    let faults = generator.subschema_for::<FaultsAnswer>();
    let refusals = REFUSALS.map(|(status, meaning)| {
        let answer =
            json!({ "description": meaning, "content": { "application/json": { "schema": faults } } });
        (status.to_owned(), answer)
    });
    json!({
        "openapi": "3.1.0",
        "info": {
            "title": "nextview",
            "version": env!("CARGO_PKG_VERSION"),
            "description": "Scans of unknown objects by any depth camera: frames in, next views out.",
            "license": { "name": "MIT OR Apache-2.0", "identifier": "MIT OR Apache-2.0" },
        },
        "servers": [{ "url": "/" }],
        "security": [{ "token": [] }, {}],
        "paths": paths,
        "components": {
            "schemas": generator.take_definitions(true),
            "responses": Map::from_iter(refusals),
            "securitySchemes": { "token": { "type": "http", "scheme": "bearer" } },
        },
    })
}

fn path(route: &Route, generator: &mut SchemaGenerator) -> Value {
    let names = route.path.split('/').filter_map(|part| part.strip_prefix('{')?.strip_suffix('}'));
    let parameters: Vec<Value> = names
        .map(|name| {
            let kind = if name == "step" { "integer" } else { "string" };
            json!({ "name": name, "in": "path", "required": true, "schema": { "type": kind } })
        })
        .collect();
    let mut path = Map::new();
    for Operation { method, doc } in &route.operations {
        path.insert(method.name().to_owned(), operation(doc, generator));
    }
    if !parameters.is_empty() {
        path.insert("parameters".to_owned(), parameters.into());
    }
    path.into()
}

fn operation(doc: &Doc, generator: &mut SchemaGenerator) -> Value {
    let answer =
        json!({ "description": "done", "content": contents(std::slice::from_ref(&doc.answer), generator) });
    let mut responses = Map::from_iter([(doc.status.to_owned(), answer)]);
    for (status, _) in REFUSALS {
        responses.insert(status.to_owned(), json!({ "$ref": format!("#/components/responses/{status}") }));
    }
    let mut operation = Map::from_iter([
        ("summary".to_owned(), doc.summary.into()),
        ("responses".to_owned(), responses.into()),
    ]);
    if !doc.bodies.is_empty() {
        let body = json!({ "required": true, "content": contents(&doc.bodies, generator) });
        operation.insert("requestBody".to_owned(), body);
    }
    if let Some(query) = doc.query {
        operation.insert("parameters".to_owned(), query_parameters(query(generator).to_value()));
    }
    operation.into()
}

fn contents(contents: &[Content], generator: &mut SchemaGenerator) -> Value {
    let content = |content: &Content| {
        let schema = content.schema.map_or_else(|| json!({}), |schema| schema(generator).to_value());
        (content.kind.to_owned(), json!({ "schema": schema }))
    };
    contents.iter().map(content).collect::<Map<_, _>>().into()
}

/// Converts the properties of an object to query parameters.
fn query_parameters(mut schema: Value) -> Value {
    let Some(Value::Object(properties)) = schema.get_mut("properties").map(Value::take) else {
        return json!([]);
    };
    let parameter = |(name, mut schema): (String, Value)| {
        let description = schema.as_object_mut().and_then(|schema| schema.remove("description"));
        json!({ "name": name, "in": "query", "description": description.unwrap_or_default(), "schema": schema })
    };
    properties.into_iter().map(parameter).collect()
}
