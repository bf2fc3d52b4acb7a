// The proposed view with its reasons, and the controls of the scan.
const percentText = (share) => `${Math.round(100 * share)} %`;
const plainText = (value) => String(+value.toPrecision(3));

// What is said of a view, in this order; the planner's own quantities follow.
const REASONS = {
  expected_new_voxels: ["New voxels expected", (n) => String(Math.round(n))],
  expected_unseen_voxels: ["Expected from all other views", (n) => String(Math.round(n))],
  estimated_completeness: ["Estimated completeness", percentText],
  forecast_completeness: ["After the next views", (shares) => `${shares.map((share) => Math.round(100 * share)).join(", ")} %`],
  trajectory_length_m: ["Path length", lengthText],
  trajectory_time_s: ["Travel time", (seconds) => `${plainText(seconds)} s`],
  score: ["Score", plainText],
  runner_up: ["Next best", (view) => `view ${view}`],
};

const viewName = ({ view }) => (view === undefined ? "the given first view" : `view ${view}`);

function proposalText({ state, view, stop_reason: reason }, isWritten) {
  const why = reason ? `: ${reason.replaceAll("-", " ")}` : "";
  if (isWritten) return `The scan is finished${why}.`;
  if (state === "finished") return `No view is left${why}. Finish writes the results.`;
  if (state === "paused") return "The scan is paused: no view is given out.";
  return state === "proposed" ? `Waiting for ${viewName(view)} to be accepted.` : `Move the camera to ${viewName(view)}.`;
}

// What is to come, and what can be done; `summary` is the scan as the list of all has it, null if it is gone.
function showProposal(next, summary) {
  const { state, view } = next || {};
  const isWritten = Boolean(summary) && summary.state === "finished";
  byId("next-text").textContent = next ? proposalText(next, isWritten) : "";
  const known = Object.entries(REASONS).filter(([name]) => view && view[name] !== undefined);
  const reasons = known.map(([name, [label, text]]) => [label, text(view[name])]);
  const own = Object.entries(view && view.explanation || {}).map(([name, value]) => [name.replaceAll("_", " "), plainText(value)]);
  byId("next-reasons").replaceChildren(...reasons.concat(own).map(([label, text]) =>
    element("div", {}, element("dt", { textContent: label }), element("dd", { textContent: text }))));
  const isOver = !summary || isWritten;
  byId("continue").disabled = isOver || state !== "paused";
  byId("pause").disabled = isOver || state === "paused";
  byId("accept").disabled = isOver || state !== "proposed";
  byId("skip").disabled = isOver || !view || view.view === undefined;
  byId("finish").disabled = isOver;
  for (const button of byId("downloads").children) {
    button.disabled = !summary || !summary.n_frames || (button.value === "report.html" && !isWritten);
  }
  if (isOver || !view) showGuidance(null);
}

// `base` gives the address of the scan, `proposed` the number of the view, `perform` runs and reports.
function startProposal(base, proposed, perform) {
  const act = (name, body) => byId(name).addEventListener("click", () => perform(() => post(`${base()}/${name}`, body())));
  act("continue", () => ({}));
  act("pause", () => ({}));
  act("accept", () => ({ view: proposed() }));
  act("skip", () => ({ view: proposed(), reason: byId("reason").value || "skipped on the page" }));
  byId("finish").addEventListener("click", () => {
    if (confirm("Finish the scan? It accepts no frames afterwards.")) perform(() => post(`${base()}/finish`));
  });
  const files = { "cloud.ply": "Cloud", "mesh.ply": "Mesh", "map.ot": "Map", "record.json": "Record", "report.html": "Report" };
  for (const [value, textContent] of Object.entries(files)) {
    const button = element("button", { type: "button", value, textContent, disabled: true });
    button.addEventListener("click", () => perform(() => download(`${base()}/files/${value}`, `${base().split("/").pop()}-${value}`)));
    byId("downloads").append(button);
  }
  showProposal(null, null);
}

// A link alone could not send the token.
async function download(path, name) {
  const href = URL.createObjectURL(await (await request(path)).blob());
  element("a", { href, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(href), 60000);
}
