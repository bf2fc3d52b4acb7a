// A report: the scene stands in the page.
(() => {
  const view = startScene();
  if (!view) return;
  view.load(JSON.parse(byId("scene").textContent));
  // Print with the configuration that the screen folds away.
  const details = document.querySelector("details");
  let wasOpen = false;
  addEventListener("beforeprint", () => {
    wasOpen = details.open;
    details.open = true;
    view.draw();
  });
  addEventListener("afterprint", () => {
    details.open = wasOpen;
    view.redraw();
  });
})();
