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

  // What it changes comes as an event.
  async function perform(action) {
    try {
      await action();
      showFault("action", null);
    } catch (error) {
      showFault("action", error);
    }
  }

  // Texts and tables are made by the server, which escapes all that is not its own.
  function showPanels(panels, after) {
    byId("title").textContent = panels.title;
    document.title = `${panels.title} – nextview`;
    for (const part of ["subtitle", "headline", "chart", "placement", "measures", "views"]) byId(part).innerHTML = panels[part];
    pictures = pictures.slice(0, after).concat(panels.pictures.map((html, i) => {
      const holder = element("div", { className: "pictures", innerHTML: html });
      holder.dataset.step = after + i + 1;
      return holder;
    }));
    byId("views").querySelectorAll("td.depth").forEach((cell, i) => cell.append(pictures[i] || ""));
  }

  function showScene(data) {
    [nViews, lens] = [data.n_views, data.lens];
    showPanels(data.panels, data.after);
    if (view) view.load(data);
  }

  // The page's policy knows pictures from the server and from data, and requests need the token.
  wholePicture = async (small) => {
    const { step } = small.closest(".pictures").dataset;
    const blob = await (await request(`${base()}/frames/${step}/${small.dataset.kind}.png`)).blob();
    return new Promise((resolve, reject) => {
      const reader = new FileReader();
      Object.assign(reader, { onload: () => resolve(reader.result), onerror: reject });
      reader.readAsDataURL(blob);
    });
  };

  // One refresh at a time; what happens meanwhile asks for another one.
  let isLoading = false;
  let isStale = false;
  async function refresh() {
    isStale = true;
    if (isLoading || id === null) return;
    isLoading = true;
    while (isStale) {
      isStale = false;
      try {
        await load();
        showFault("look", null);
      } catch (error) {
        showFault("look", error);
      }
    }
    isLoading = false;
  }

  async function load() {
    const [of, after] = [id, nViews];
    const next = await getJson(`${base()}/next`).catch((error) => {
      if (error.status === 404) return null;
      throw error;
    });
    // After `next`, which waits for what is being done to the scan: the list alone would say how it was before.
    const summary = (await listScans()).find((scan) => scan.id === of);
    const data = summary && await getJson(`${base()}/scene?after=${after}`);
    if (of !== id || after !== nViews) return;
    proposal = next;
    if (!next || !summary) return gone();
    showScene(data);
    showProposal(next, summary);
    byId("scan-on").hidden = summary.state !== "finished" || !data.panels.placement;
  }

  // A scan of the same camera, in which the object lies as asked for.
  async function scanOn() {
    const made = await (await post("/scans", { after: id })).json();
    await listScans();
    choose(made.id);
  }

  function gone() {
    listening.abort();
    connection("this scan was deleted", true);
    showProposal(null, null);
  }

  function onEvent(name, text) {
    const data = text ? JSON.parse(text) : {};
    if (name === "pose") {
      showTracking({ lost: false });
      showGuidance(data.guidance);
      if (view && lens) view.moveCamera(cameraAt(data.world_from_camera, lens));
    } else if (name === "tracking") showTracking(data);
    else if (name === "deleted") {
      gone();
      listScans().catch((error) => showFault("look", error));
    } else {
      if (name === "gap") nViews = 0;
      // A view comes with the scene of the frame that led to it.
      if (name !== "view") refresh();
    }
  }

  async function listen() {
    listening.abort();
    const mine = listening = new AbortController();
    let wait = 1;
    while (!mine.signal.aborted) {
      try {
        await readEvents(`${base()}/events`, mine.signal, () => {
          connection("live");
          [wait, nViews] = [1, 0]; // what happened before is not told
          refresh();
        }, onEvent);
      } catch (error) {
        if (mine.signal.aborted) return;
        if (error.status) showFault("look", error);
        if (error.status === 401) return;
        if (error.status === 404) return refresh();
      }
      if (mine.signal.aborted) return;
      connection(`connection lost; next try in ${wait} s`, true);
      await new Promise((resolve) => setTimeout(resolve, 1000 * wait));
      wait = Math.min(2 * wait, 15);
    }
  }

  function choose(chosen) {
    [id, nViews, pictures, proposal] = [chosen, 0, [], null];
    history.replaceState(null, "", `${base()}/page`);
    if (view) view.moveCamera(null);
    showTracking({ lost: false });
    showGuidance(null);
    showFault("action", null);
    listen();
  }

  async function listScans() {
    const scans = await getJson("/scans");
    const frames = ({ n_frames: n }) => (n === null ? "" : n === 1 ? ", 1 frame" : `, ${n} frames`);
    const text = (scan) => `${scan.id}: ${scan.object} (${scan.state}${frames(scan)})`;
    const options = scans.map((scan) => element("option", { value: scan.id, textContent: text(scan) }));
    const isNew = options.map((option) => option.text).join("\n") !== [...byId("scans").options].map((option) => option.text).join("\n");
    if (isNew) byId("scans").replaceChildren(...options);
    byId("scans").value = id;
    return scans;
  }

  // Shows the newest scan that is under way, or else the newest.
  async function begin() {
    try {
      const scans = await listScans();
      showFault("look", null);
      const byAge = scans.sort((a, b) => (a.created < b.created ? -1 : 1));
      const newest = byAge.filter((scan) => scan.state !== "finished").pop() || byAge.pop();
      if (id !== null || newest) return choose(id === null ? newest.id : id);
      connection("no scan yet; it will appear here");
    } catch (error) {
      showFault("look", error);
      connection("not connected", true);
      if (error.status === 401) return;
    }
    setTimeout(begin, 3000);
  }

  byId("scan-on").addEventListener("click", () => perform(scanOn));
  byId("scans").addEventListener("change", () => choose(byId("scans").value));
  byId("token-form").addEventListener("submit", (e) => {
    e.preventDefault();
    keepToken(byId("token").value);
    byId("token-form").hidden = true;
    begin();
  });
  startProposal(base, () => proposal && proposal.view ? proposal.view.view : null, perform);
  begin();
})();
