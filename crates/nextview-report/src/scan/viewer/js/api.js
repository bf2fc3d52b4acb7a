// Requests to the server. Its token comes in the address, `#token=…`, and is taken out of it at once.
const TOKEN_KEY = "nextview-token";

function takeToken() {
  const given = new URLSearchParams(location.hash.slice(1)).get("token");
  if (!given) return;
  keepToken(given);
  history.replaceState(null, "", location.pathname + location.search);
}

// A browser may forbid storage; the token then lives as long as the page.
let tokenInMemory = "";
function keepToken(token) {
  tokenInMemory = token;
  try {
    sessionStorage.setItem(TOKEN_KEY, token);
  } catch { /* forbidden */ }
}

function token() {
  try {
    return sessionStorage.getItem(TOKEN_KEY) || tokenInMemory;
  } catch {
    return tokenInMemory;
  }
}

async function request(path, options = {}) {
  const headers = { ...(token() ? { Authorization: `Bearer ${token()}` } : {}), ...options.headers };
  const response = await fetch(path, { ...options, headers });
  if (response.ok) return response;
  const { faults = [] } = await response.json().catch(() => ({}));
  const words = faults.map(({ message, remedy }) => [message, remedy].filter(Boolean).join("; "));
  const error = new Error(words.join(". ") || `the server responded with status ${response.status}`);
  throw Object.assign(error, { status: response.status });
}

const getJson = async (path) => (await request(path)).json();

function post(path, body = {}) {
  const headers = { "Content-Type": "application/json" };
  return request(path, { method: "POST", headers, body: JSON.stringify(body) });
}

// Reads server-sent events until the connection ends: EventSource cannot send a token.
async function readEvents(path, signal, onOpen, onEvent) {
  const response = await request(path, { signal, headers: { Accept: "text/event-stream" } });
  onOpen();
  const reader = response.body.pipeThrough(new TextDecoderStream()).getReader();
  let text = "";
  for (;;) {
    const { value, done } = await reader.read();
    if (done) return;
    text = (text + value).replaceAll("\r\n", "\n");
    const messages = text.split("\n\n");
    text = messages.pop();
    for (const message of messages) {
      const fields = (name) => message.split("\n").filter((line) => line.startsWith(`${name}:`))
        .map((line) => line.slice(name.length + 1).replace(/^ /, ""));
      const data = fields("data").join("\n");
      if (data || fields("event").length) onEvent(fields("event")[0] || "message", data);
    }
  }
}
