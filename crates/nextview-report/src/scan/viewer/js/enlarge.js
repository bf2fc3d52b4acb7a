// Fetches the full-size picture of a thumbnail as a data URL; `null` if there is no server.
let wholePicture = null;

// Pictures of the views, enlarged in a dialog; also without WebGL.
(() => {
  const dialog = byId("enlarged");
  let at = 0;
  const pictures = () => [...document.querySelectorAll("button.enlarge img")];

  function open(index) {
    const all = pictures();
    at = (index + all.length) % all.length;
    const small = all[at];
    show(small, small.src);
    if (!dialog.open) dialog.showModal();
    // The small picture stays where the whole one does not come.
    if (wholePicture) wholePicture(small).then((src) => isShown(small) && show(small, src), () => {});
  }

  const isShown = (small) => dialog.open && pictures()[at] === small;

  function show({ alt }, src) {
    Object.assign(byId("enlarged-picture"), { src, alt });
    byId("enlarged-caption").textContent = alt;
  }

  document.addEventListener("click", (e) => {
    const button = e.target.closest("button.enlarge");
    if (button) open(pictures().indexOf(button.querySelector("img")));
  });
  byId("enlarged-before").addEventListener("click", () => open(at - 1));
  byId("enlarged-after").addEventListener("click", () => open(at + 1));
  byId("enlarged-close").addEventListener("click", () => dialog.close());
  dialog.addEventListener("keydown", (e) => {
    if (e.key === "ArrowLeft") open(at - 1);
    if (e.key === "ArrowRight") open(at + 1);
  });
  dialog.addEventListener("click", (e) => {
    if (e.target === dialog) dialog.close();
  });
})();
