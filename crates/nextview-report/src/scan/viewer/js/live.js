// The live page: one scan of a server, as it happens.
(() => {
  takeToken();
  const view = startScene();
  const named = location.pathname.match(/^\/scans\/([^/]+)/);
  let id = named && decodeURIComponent(named[1]);
  let listening = new AbortController();
  let nViews = 0;
  let lens = null;
  let proposal = null;
  let pictures = [];
  const base = () => `/scans/${encodeURIComponent(id)}`;

  function connection(words, isLost = false) {
    byId("connection").textContent = words;
    byId("connection").classList.toggle("lost", isLost);
  }

  function failure(error) {
    byId("failure").hidden = !error;
    byId("failure").textContent = error ? error.message : "";
    if (error && (error.status === 401 || error.status === 403)) byId("token-form").hidden = false;
  }

  async function perform(action) {
    try {
      await action();
      failure(null);
    } catch (error) {
      failure(error);
    }
    refresh();
  }

  // Texts and tables are made by the server, which escapes all that is not its own.
  function showPanels(panels, after) {
    byId("title").textContent = panels.title;
    document.title = `${panels.title} – nextview`;
    for (const part of ["subtitle", "headline", "chart", "measures", "views"]) byId(part).innerHTML = panels[part];
    pictures = pictures.slice(0, after).concat(panels.pictures.map((html) => element("div", { className: "pictures", innerHTML: html })));
    byId("views").querySelectorAll("td.depth").forEach((cell, i) => cell.append(pictures[i] || ""));
  }

  // One refresh at a time; what happens meanwhile asks for another one.
  let isLoading = false;
  let isStale = false;
  async function refresh() {
    isStale = true;
    if (isLoading || !id) return;
    isLoading = true;
    while (isStale) {
      isStale = false;
      try {
        await load();
      } catch (error) {
        failure(error);
      }
    }
    isLoading = false;
  }

  async function load() {
    const of = id;
    const data = await getJson(`${base()}/scene?after=${nViews}`);
    if (of !== id) return;
    [nViews, lens] = [data.n_views, data.lens];
    showPanels(data.panels, data.after);
    if (view) view.load(data);
    proposal = await getJson(`${base()}/next`);
    if (of === id) showProposal(proposal);
  }

  function onEvent(name, text) {
    let data = {};
    try {
      data = text ? JSON.parse(text) : {};
    } catch { /* a comment */ }
    if (name === "pose") {
      if (data.guidance) showGuidance(data.guidance);
      if (view && lens && data.world_from_camera) view.moveCamera(cameraAt(data.world_from_camera, lens));
    } else if (name === "tracking") showTracking(data);
    else if (name === "deleted") {
      listening.abort();
      connection("this scan was deleted", true);
      listScans();
    } else refresh();
  }

  async function listen() {
    listening.abort();
    const mine = listening = new AbortController();
    let wait = 1;
    while (!mine.signal.aborted) {
      try {
        await readEvents(`${base()}/events`, mine.signal, () => {
          connection("live");
          wait = 1;
          refresh();
        }, onEvent);
      } catch (error) {
        if (error.status) failure(error);
        if (error.status === 404) break;
      }
      if (mine.signal.aborted) return;
      connection(`connection lost; next try in ${wait} s`, true);
      await new Promise((resolve) => setTimeout(resolve, 1000 * wait));
      wait = Math.min(2 * wait, 15);
    }
  }

  function choose(chosen) {
    [id, nViews, pictures, proposal] = [chosen, 0, [], null];
    if (view) view.moveCamera(null);
    byId("guidance").hidden = true;
    listen();
  }

  async function listScans() {
    try {
      const scans = await getJson("/scans");
      const text = (scan) => `${scan.object} (${scan.state}, ${scan.n_frames} frames)`;
      const options = scans.map((scan) => element("option", { value: scan.id, textContent: text(scan) }));
      byId("scans").replaceChildren(...options);
      failure(null);
      if (!scans.length) connection("no scan yet; it will show here");
      if (id === null && scans.length) id = String(scans[scans.length - 1].id);
      if (id !== null) byId("scans").value = id;
    } catch (error) {
      failure(error);
      connection("connection lost", true);
    }
  }

  async function begin() {
    await listScans();
    if (id !== null) listen();
    else setTimeout(begin, 3000);
  }

  byId("scans").addEventListener("change", () => choose(byId("scans").value));
  byId("token-form").addEventListener("submit", (e) => {
    e.preventDefault();
    keepToken(byId("token").value);
    byId("token-form").hidden = true;
    begin();
  });
  startProposal(base, () => (proposal && proposal.view ? proposal.view.index : null), perform);
  begin();
})();
