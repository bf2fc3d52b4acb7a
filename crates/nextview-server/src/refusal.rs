use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use nextview_scan::{Fault, FaultKind, Faults};
use schemars::JsonSchema;
use serde::Serialize;

/// A refused request: a status and at least one fault.
#[derive(Debug)]
pub(crate) struct Refusal {
    pub status: StatusCode,
    pub faults: Faults,
    /// Seconds until a retry is useful.
    pub retry_after_s: Option<u32>,
}

/// A fault in an answer.
#[derive(Serialize, JsonSchema)]
pub(crate) struct FaultAnswer {
    /// `request`: the client can correct it; `data`: a file or the system is at fault; `cancelled`: repeat
    /// the request.
    kind: &'static str,
    /// Dotted key of the invalid value; `None` if the fault is not about one value.
    key: Option<String>,
    /// The given value.
    value: Option<String>,
    /// The expected value.
    expected: Option<String>,
    /// The whole fault as a sentence.
    message: String,
    /// The remedy.
    remedy: Option<String>,
}

/// All faults found.
#[derive(Serialize, JsonSchema)]
pub(crate) struct FaultsAnswer {
    /// At least one.
    faults: Vec<FaultAnswer>,
}

impl Refusal {
    pub fn new(status: StatusCode, fault: impl Into<Faults>) -> Self {
        Self { status, faults: fault.into(), retry_after_s: None }
    }

    /// Refuses with a message only.
    pub fn of(status: StatusCode, message: impl std::fmt::Display) -> Self {
        Self::new(status, Fault::request(message))
    }

    /// Refuses because the server is busy.
    pub fn busy(status: StatusCode, fault: Fault) -> Self {
        Self { retry_after_s: Some(1), ..Self::new(status, fault.with_remedy("try again in a second")) }
    }

    /// Whether a computation was cancelled.
    pub fn is_cancelled(&self) -> bool {
        self.faults.iter().any(|fault| fault.kind == FaultKind::Cancelled)
    }

    /// Refuses invalid content.
    pub fn content(faults: impl Into<Faults>) -> Self {
        Self::new(StatusCode::UNPROCESSABLE_ENTITY, faults)
    }
}

impl From<Faults> for Refusal {
    fn from(faults: Faults) -> Self {
        let is = |kind| faults.iter().any(|fault| fault.kind == kind);
        let status = match () {
            _ if is(FaultKind::Data) => StatusCode::INTERNAL_SERVER_ERROR,
            _ if is(FaultKind::Request) => StatusCode::UNPROCESSABLE_ENTITY,
            _ => StatusCode::SERVICE_UNAVAILABLE,
        };
        Self::new(status, faults)
    }
}

impl From<Fault> for Refusal {
    fn from(fault: Fault) -> Self {
        Faults::from(fault).into()
    }
}

impl From<&Fault> for FaultAnswer {
    fn from(fault: &Fault) -> Self {
        // Paths on the server's disk are confidential, and clients cannot repair files.
        let remedy = fault.remedy.clone().filter(|_| fault.place.is_none());
        let file = fault.place.as_ref().and_then(|place| place.file.file_name());
        let file = file.map(|name| format!("{}: ", name.to_string_lossy())).unwrap_or_default();
        Self {
            kind: match fault.kind {
                FaultKind::Request => "request",
                FaultKind::Data => "data",
                FaultKind::Cancelled => "cancelled",
            },
            key: fault.key.clone(),
            value: fault.value.clone(),
            expected: fault.expected.clone(),
            message: format!("{file}{}", fault.message),
            remedy,
        }
    }
}

impl IntoResponse for Refusal {
    fn into_response(self) -> Response {
        let answer = FaultsAnswer { faults: self.faults.iter().map(FaultAnswer::from).collect() };
        let mut response = (self.status, axum::Json(answer)).into_response();
        let headers = response.headers_mut();
        if let Some(seconds) = self.retry_after_s {
            headers.insert(header::RETRY_AFTER, seconds.into());
        }
        if self.status == StatusCode::UNAUTHORIZED {
            headers.insert(header::WWW_AUTHENTICATE, header::HeaderValue::from_static("Bearer"));
        }
        response
    }
}
