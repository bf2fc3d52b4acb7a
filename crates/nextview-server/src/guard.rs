use crate::app::App;
use crate::refusal::Refusal;
use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderName, HeaderValue, StatusCode, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use nextview_report::live;
use nextview_scan::Fault;
use std::sync::Arc;

/// Passes authorised requests on, and sets the security headers of every answer.
pub(crate) async fn guard(State(app): State<Arc<App>>, request: Request, next: Next) -> Response {
    let mut response = match check(&app, &request) {
        Ok(()) => next.run(request).await,
        Err(refusal) => refusal.into_response(),
    };
    let stated = [
        (header::CONTENT_SECURITY_POLICY, live::CONTENT_SECURITY_POLICY),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::REFERRER_POLICY, "no-referrer"),
        (HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
        (header::CACHE_CONTROL, "no-store"),
    ];
    stated.into_iter().for_each(|(name, value)| {
        _ = response.headers_mut().insert(name, HeaderValue::from_static(value));
    });
    response
}

fn check(app: &App, request: &Request) -> Result<(), Refusal> {
    let headers = request.headers();
    let host = text(headers, header::HOST)?.unwrap_or_default();
    // A request line may name a host, too.
    let stated = request.uri().authority().map(|authority| authority.as_str());
    if let Some(other) = [Some(host), stated].into_iter().flatten().find(|host| !app.access.hosts.has(host)) {
        let fault = Fault::of_value("host", other, app.access.hosts.expected());
        let fault = fault.with_remedy("to use another name, start the server with that name as `host`");
        return Err(Refusal::new(StatusCode::FORBIDDEN, fault));
    }
    check_origin(headers, host)?;
    let is_open = is_static(request.uri().path());
    let given = text(headers, header::AUTHORIZATION)?;
    let token = given.map(|given| given.strip_prefix("Bearer ").unwrap_or_default());
    match (token, &app.access.clients) {
        _ if is_open => Ok(()),
        (Some(token), clients) => {
            let is_clients = clients.as_ref().is_some_and(|clients| clients.is(token.as_bytes()));
            let is_known = is_clients || app.access.page.is(token.as_bytes());
            if is_known { Ok(()) } else { Err(unknown("the token is not that of this server")) }
        }
        (None, None) if !is_browser(headers) => Ok(()),
        (None, None) => Err(unknown("a browser needs the page's token")),
        (None, Some(_)) => Err(unknown("a token is needed")),
    }
}

/// Refuses requests from pages of other servers.
fn check_origin(headers: &HeaderMap, host: &str) -> Result<(), Refusal> {
    let Some(origin) = text(headers, header::ORIGIN)? else { return Ok(()) };
    let authority = origin.strip_prefix("http://").or_else(|| origin.strip_prefix("https://"));
    if authority.is_some_and(|authority| authority.eq_ignore_ascii_case(host)) {
        return Ok(());
    }
    let fault = Fault::of_value("origin", origin, format!("http://{host}"));
    Err(Refusal::new(StatusCode::FORBIDDEN, fault.with_remedy("send requests from the page of this server")))
}

/// Whether a web page may have sent a request, be it only for an image that it shows: even a query may decide
/// the next view. Browsers state the origin of a request; those that do not, such as old ones or those over
/// plain HTTP, send their name and their user's languages, which a page cannot suppress.
fn is_browser(headers: &HeaderMap) -> bool {
    let names_page = [header::ORIGIN, header::REFERER, HeaderName::from_static("sec-fetch-site")];
    let begins = |name, start: &[u8]| {
        headers.get(name).is_some_and(|value: &HeaderValue| value.as_bytes().starts_with(start))
    };
    // Programs that set languages accept any.
    let has_languages = headers.get(header::ACCEPT_LANGUAGE).is_some_and(|languages| languages != "*");
    names_page.iter().any(|name| headers.contains_key(name))
        || begins(header::USER_AGENT, b"Mozilla/")
        || has_languages
}

/// Whether the content is the same for all clients.
fn is_static(path: &str) -> bool {
    let is_page = path.strip_prefix("/scans/").and_then(|rest| rest.strip_suffix("/page"));
    path == "/"
        || path == "/healthz"
        || path.starts_with("/assets/")
        || is_page.is_some_and(|id| !id.contains('/'))
}

fn unknown(message: &str) -> Refusal {
    let remedy = "send the header `Authorization: Bearer TOKEN`; the server prints the page's token when it starts, \
                  all other clients use the one in its token file";
    Refusal::new(StatusCode::UNAUTHORIZED, Fault::request(message).with_remedy(remedy))
}

/// The value of a header that may occur once.
fn text(headers: &HeaderMap, name: HeaderName) -> Result<Option<&str>, Refusal> {
    let mut values = headers.get_all(&name).iter();
    let value = values.next().map(HeaderValue::to_str).transpose();
    match (value, values.next()) {
        (Ok(value), None) => Ok(value),
        _ => Err(Refusal::of(
            StatusCode::BAD_REQUEST,
            format!("the header `{name}` must occur once, as visible ASCII"),
        )),
    }
}
