// The controls around the 3D view.
const byId = (id) => document.getElementById(id);

function element(name, properties = {}, ...children) {
  const made = Object.assign(document.createElement(name), properties);
  made.append(...children);
  return made;
}

// A strip with the colours of a ramp.
function rampStrip(ramp) {
  const strip = element("canvas", { width: 64, height: 1, className: "strip" });
  const ctx = strip.getContext("2d");
  for (let x = 0; x < 64; x++) {
    ctx.fillStyle = `rgb(${onRamp(ramp, x / 63)})`;
    ctx.fillRect(x, 0, 1, 1);
  }
  return strip;
}

function startPanel(view) {
  const { scene, show } = view;
  const [slider, colouring, key] = [byId("slider"), byId("colouring"), byId("key")];

  function keyLine(...parts) {
    key.append(element("span", {}, ...parts));
  }

  function writeKey() {
    key.replaceChildren();
    if (show.surface && show.colouring === "confidence") {
      keyLine("seen once, from the side ", rampStrip(CONFIDENCE), " often, from the front");
    }
    if (show.colouring === "first view") keyLine("first seen by view 1 ", rampStrip(scene.ramp), ` ${scene.nViews}`);
    if (show.expected && scene.expected) {
      keyLine(rampStrip([EXPECTED_COLOR, EXPECTED_COLOR]), " expected, not seen yet");
    }
    if (show.candidates && scene.candidates.best > 0) {
      const best = Math.round(scene.candidates.best);
      keyLine("candidates: 0 ", rampStrip(CONFIDENCE), ` ${best} new voxels expected`);
    }
  }

  // After a scene was loaded: the slider stays at the end if it was there.
  function update() {
    const isAtEnd = show.shown >= +slider.max;
    slider.max = Math.max(scene.nViews, 1);
    if (isAtEnd) slider.value = slider.max;
    show.shown = isAtEnd ? Infinity : +slider.value;
    byId("shown").value = `${Math.min(show.shown, scene.nViews)} of ${scene.nViews}`;
    const offered = COLOURINGS.filter((name) => name !== "colour" || (scene.surface && scene.surface.hasColors));
    if (offered.length !== colouring.options.length) {
      // Colour where there is some is what people look for first.
      show.colouring = offered.includes("colour") ? "colour" : offered.includes(show.colouring) ? show.colouring : "shape";
      colouring.replaceChildren(...offered.map((value) => element("option", { value, textContent: value })));
      colouring.value = show.colouring;
    }
    writeKey();
    view.redraw();
  }

  slider.addEventListener("input", () => {
    show.shown = +slider.value >= +slider.max ? Infinity : +slider.value;
    update();
  });
  colouring.addEventListener("change", () => {
    show.colouring = colouring.value;
    update();
  });
  for (const part of ["surface", "points", "expected", "cameras", "candidates"]) {
    const box = byId(`show-${part}`);
    show[part] = box.checked;
    box.addEventListener("change", () => {
      show[part] = box.checked;
      update();
    });
  }
  byId("frame-object").addEventListener("click", view.reset);
  byId("frame-cameras").addEventListener("click", view.frameCameras);
  return update;
}

// Starts the 3D view; `null` if the browser cannot draw it.
function startScene() {
  const canvas = byId("canvas");
  const gl = startGl(canvas);
  if (!gl) return null;
  byId("scene-message").hidden = true;
  byId("scene-view").hidden = false;
  const view = startView(gl, canvas, byId("labels"));
  startControls(view, canvas);
  const update = startPanel(view);
  new ResizeObserver(view.resized).observe(canvas);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", view.redraw);
  return { ...view, load: (data) => { view.load(data); update(); } };
}
