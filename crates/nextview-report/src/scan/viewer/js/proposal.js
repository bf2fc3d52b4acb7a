// The proposed view with its reasons, and the controls of the scan.
const STATE_TEXT = {
  view: "The camera is to go to", proposed: "Proposed is", paused: "The scan is paused; next would be", finished: "The scan is over",
};

function showProposal({ state, view, stop_reason: reason }) {
  const place = view && (view.index === null || view.index === undefined ? "the given view" : `view ${view.index}`);
  const end = state === "finished" ? (reason ? `: ${String(reason).replaceAll("-", " ")}` : "") : place ? ` ${place}` : " nothing";
  byId("next-text").textContent = `${STATE_TEXT[state] || state}${end}.`;
  const plain = (value) => (typeof value === "number" ? String(+value.toPrecision(3)) : String(value));
  const { explanation, index, world_from_camera: _pose, ...rest } = view || {};
  const reasons = { ...rest, ...explanation };
  const isShown = ([, value]) => ["number", "string", "boolean"].includes(typeof value);
  byId("next-reasons").replaceChildren(...Object.entries(reasons).filter(isShown).map(([name, value]) =>
    element("div", {}, element("dt", { textContent: name.replaceAll("_", " ") }), element("dd", { textContent: plain(value) }))));
  const over = state === "finished";
  byId("continue").disabled = state !== "paused";
  byId("pause").disabled = over || state === "paused";
  byId("accept").disabled = state !== "proposed";
  byId("skip").disabled = over || !view || typeof index !== "number";
  byId("finish").disabled = over;
  if (over) byId("guidance").hidden = true;
}

// `base` gives the address of the scan, `proposed` the number of the view, `perform` runs and reports.
function startProposal(base, proposed, perform) {
  const act = (name, body) => byId(name).addEventListener("click", () => perform(() => post(`${base()}/${name}`, body())));
  act("continue", () => ({}));
  act("pause", () => ({}));
  act("accept", () => ({ view: proposed() }));
  act("skip", () => ({ view: proposed(), reason: byId("reason").value || "skipped on the page" }));
  byId("finish").addEventListener("click", () => {
    if (confirm("Finish the scan? No more frames are taken.")) perform(() => post(`${base()}/finish`));
  });
  const files = { "cloud.ply": "Cloud", "mesh.ply": "Mesh", "map.ot": "Map", "record.json": "Record", "report.html": "Report" };
  for (const [name, textContent] of Object.entries(files)) {
    const button = element("button", { type: "button", textContent });
    button.addEventListener("click", () => perform(async () => {
      const href = URL.createObjectURL(await (await request(`${base()}/files/${name}`)).blob());
      element("a", { href, download: name }).click();
      setTimeout(() => URL.revokeObjectURL(href), 60000);
    }));
    byId("downloads").append(button);
  }
}
