use crate::app::App;
use axum::handler::Handler;
use axum::routing::{MethodFilter, MethodRouter};
use schemars::{JsonSchema, Schema, SchemaGenerator};
use std::sync::Arc;

/// A path and its operations.
pub(crate) struct Route {
    pub path: &'static str,
    pub operations: Vec<Operation>,
    pub handlers: MethodRouter<Arc<App>>,
}

/// The operation of a method at a path.
pub(crate) struct Operation {
    pub method: Method,
    pub doc: Doc,
}

#[derive(Clone, Copy)]
pub(crate) enum Method {
    Get,
    Post,
    Delete,
}

/// Description of an operation.
pub(crate) struct Doc {
    pub summary: &'static str,
    /// Names and meanings of the query parameters.
    pub query: Option<SchemaOf>,
    pub bodies: Vec<Content>,
    pub status: &'static str,
    pub answer: Content,
}

/// Makes the schema of a type.
pub(crate) type SchemaOf = fn(&mut SchemaGenerator) -> Schema;

/// A body by content type; without a schema, it is bytes or text.
pub(crate) struct Content {
    pub kind: &'static str,
    pub schema: Option<SchemaOf>,
}

impl Content {
    pub fn json<T: JsonSchema>() -> Self {
        Self { kind: "application/json", schema: Some(SchemaGenerator::subschema_for::<T>) }
    }

    pub fn of(kind: &'static str) -> Self {
        Self { kind, schema: None }
    }
}

impl Doc {
    pub fn new(summary: &'static str, answer: Content) -> Self {
        Self { summary, query: None, bodies: Vec::new(), status: "200", answer }
    }

    pub fn taking(mut self, body: Content) -> Self {
        self.bodies.push(body);
        self
    }

    pub fn with_query<T: JsonSchema>(self) -> Self {
        Self { query: Some(|generator| T::json_schema(generator)), ..self }
    }

    pub fn creating(self) -> Self {
        Self { status: "201", ..self }
    }
}

impl Route {
    pub fn new(path: &'static str) -> Self {
        Self { path, operations: Vec::new(), handlers: MethodRouter::new() }
    }

    pub fn on<H, T>(mut self, method: Method, doc: Doc, handler: H) -> Self
    where
        H: Handler<T, Arc<App>>,
        T: 'static,
    {
        self.operations.push(Operation { method, doc });
        self.handlers = self.handlers.on(method.filter(), handler);
        self
    }
}

impl Method {
    fn filter(self) -> MethodFilter {
        match self {
            Self::Get => MethodFilter::GET,
            Self::Post => MethodFilter::POST,
            Self::Delete => MethodFilter::DELETE,
        }
    }

    pub fn name(self) -> &'static str {
        match self {
            Self::Get => "get",
            Self::Post => "post",
            Self::Delete => "delete",
        }
    }
}
