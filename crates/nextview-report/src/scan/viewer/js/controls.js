// Mouse, touch and keys. The wheel scrolls the page unless the picture was clicked, or Ctrl is held: a reader
// on the way down the page is not caught.
function startControls(view, canvas) {
  const turn = (right, up) => view.move((eye) => { eye.azimuth -= right; eye.elevation += up; });
  const zoom = (factor) => view.move((eye) => { eye.range *= factor; });
  const pointers = new Map();
  const pair = () => {
    const [a, b] = pointers.values();
    return { spread: Math.max(Math.hypot(a.x - b.x, a.y - b.y), 1), x: (a.x + b.x) / 2, y: (a.y + b.y) / 2 };
  };
  canvas.addEventListener("pointerdown", (e) => {
    canvas.setPointerCapture(e.pointerId);
    pointers.set(e.pointerId, { x: e.clientX, y: e.clientY });
  });
  canvas.addEventListener("pointermove", (e) => {
    const before = pointers.get(e.pointerId);
    if (!before) return;
    const pairBefore = pointers.size === 2 && pair();
    pointers.set(e.pointerId, { x: e.clientX, y: e.clientY });
    const [right, down] = [e.clientX - before.x, e.clientY - before.y];
    if (pairBefore) {
      const now = pair();
      zoom(pairBefore.spread / now.spread);
      view.pan(now.x - pairBefore.x, now.y - pairBefore.y);
    } else if (e.shiftKey || e.buttons & 6) view.pan(right, down);
    else turn(right * 0.008, down * 0.008);
  });
  for (const type of ["pointerup", "pointercancel", "lostpointercapture"]) {
    canvas.addEventListener(type, (e) => pointers.delete(e.pointerId));
  }
  canvas.addEventListener("contextmenu", (e) => e.preventDefault());
  canvas.addEventListener("wheel", (e) => {
    if (!(e.ctrlKey || e.metaKey || document.activeElement === canvas)) return;
    e.preventDefault();
    zoom(Math.exp((e.deltaMode ? 30 : 1) * e.deltaY * 0.0015));
  }, { passive: false });
  canvas.addEventListener("dblclick", () => view.reset());
  canvas.addEventListener("keydown", (e) => {
    const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
    const arrow = arrows[e.key];
    if (arrow && e.shiftKey) view.pan(-25 * arrow[0], -25 * arrow[1]);
    else if (arrow) turn(0.1 * arrow[0], 0.1 * arrow[1]);
    else if (e.key === "+" || e.key === "=") zoom(0.9);
    else if (e.key === "-") zoom(1 / 0.9);
    else if (e.key === "0" || e.key === "Home") view.reset();
    else if (e.key === "Escape") canvas.blur();
    else return;
    e.preventDefault();
  });
}
