"use strict";
(() => {
  const byId = (id) => document.getElementById(id);
  const canvas = byId("canvas");
  const ctx = canvas.getContext && canvas.getContext("2d");
  if (!ctx) return;
  byId("scene-message").hidden = true;
  byId("scene-view").hidden = false;

  const scene = JSON.parse(byId("scene").textContent);
  const points = decodePoints();
  const n = points.length / 3;
  const [low, high] = scene.core;
  const center = [0, 1, 2].map((k) => (low[k] + high[k]) / 2);
  const radius = Math.max(Math.hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]) / 2, 0.01);
  const FIELD = Math.tan(Math.PI / 10); // half of a field of view of 36 degrees
  const cameras = scene.views.length ? scene.views.map((v) => v.position) : scene.candidates;
  const reach = Math.max(radius, ...cameras.map((p) => distance(p, center)));
  const start = { azimuth: -0.9, elevation: 0.35, range: 2 * reach / FIELD, lift: 0 };
  let eye;

  // Drawing happens on an own pixel buffer: points overlap by depth, which the canvas cannot do.
  const layer = document.createElement("canvas");
  const layerCtx = layer.getContext("2d");
  let image, color, depth;

  function decodePoints() {
    const bytes = Uint8Array.from(atob(scene.points), (c) => c.charCodeAt(0));
    const steps = new Uint16Array(bytes.buffer); // little-endian, as is every machine that runs a browser
    return Float32Array.from(steps, (s, i) => scene.min[i % 3] + s * scene.unit[i % 3]);
  }

  function distance(a, b) {
    return Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
  }

  function resize() {
    const ratio = Math.min(window.devicePixelRatio || 1, 2);
    const width = Math.max(1, Math.round(canvas.clientWidth * ratio));
    const height = Math.max(1, Math.round(canvas.clientHeight * ratio));
    if (image && canvas.width === width && canvas.height === height) return ratio;
    canvas.width = layer.width = width;
    canvas.height = layer.height = height;
    image = layerCtx.createImageData(width, height);
    color = new Uint32Array(image.data.buffer);
    depth = new Float32Array(width * height);
    return ratio;
  }

  // Right-handed world, z up: rows are the directions right, up and towards the viewer.
  function lens() {
    const [sa, ca, se, ce] = [Math.sin(eye.azimuth), Math.cos(eye.azimuth), Math.sin(eye.elevation), Math.cos(eye.elevation)];
    const [w, h] = [canvas.width, canvas.height];
    const focal = Math.min(w, h) / 2 / FIELD;
    const rows = [[-sa, ca, 0], [-se * ca, -se * sa, ce], [ce * ca, ce * sa, se]];
    const turn = (p, row) => row[0] * (p[0] - center[0]) + row[1] * (p[1] - center[1]) + row[2] * (p[2] - center[2]);
    // The lift fades on the way in, so that the middle of the object ends up in the middle of the picture.
    const [x0, y0] = [w / 2, h / 2 + eye.lift * h * Math.min(eye.range / start.range, 1)];
    const project = (p) => {
      const z = eye.range - turn(p, rows[2]);
      const scale = focal / Math.max(z, 1e-6);
      return { x: x0 + scale * turn(p, rows[0]), y: y0 - scale * turn(p, rows[1]), z };
    };
    return { rows, focal, x0, y0, project };
  }

  // Moves the start back and shifts it up or down until the points and all cameras fill the picture.
  function fit() {
    eye = start;
    const corners = [...Array(8).keys()].map((i) => [0, 1, 2].map((k) => scene.core[i >> k & 1][k]));
    const all = corners.concat(cameras);
    for (let round = 0; round < 8; round++) {
      const { project } = lens();
      const xs = all.map((p) => project(p).x - canvas.width / 2);
      const ys = all.map((p) => project(p).y);
      const wide = 2 * Math.max(...xs.map(Math.abs)) / canvas.width;
      const high = (Math.max(...ys) - Math.min(...ys)) / canvas.height;
      if (Math.max(wide, high) < 1e-3) break; // there is nothing to fill it with
      eye.lift += 0.5 - (Math.max(...ys) + Math.min(...ys)) / 2 / canvas.height;
      eye.range *= Math.max(wide, high) / 0.86;
    }
    eye = { ...start };
  }

  function drawPoints({ rows, focal, x0, y0 }, shown, ratio) {
    color.fill(0);
    depth.fill(Infinity);
    const [w, h] = [canvas.width, canvas.height];
    const [[ax, ay], [bx, by, bz], [cx, cy, cz]] = rows;
    // As wide as the distance between neighbours if the points lay evenly on a ball.
    const spacing = 3.2 * radius / Math.sqrt(Math.max(n, 1));
    const near = 0.05 * eye.range;
    let i = 0;
    for (let view = 0; view < shown; view++) {
      const [r, g, b] = scene.views[view].color;
      const packed = (255 << 24 | b << 16 | g << 8 | r) >>> 0;
      for (const end = 3 * scene.ends[view]; i < end; i += 3) {
        const [x, y, z] = [points[i] - center[0], points[i + 1] - center[1], points[i + 2] - center[2]];
        const away = eye.range - (cx * x + cy * y + cz * z);
        if (away < near) continue;
        const scale = focal / away;
        const size = Math.min(Math.max(Math.round(scale * spacing), ratio), 7 * ratio);
        const left = Math.round(x0 + scale * (ax * x + ay * y) - size / 2);
        const top = Math.round(y0 - scale * (bx * x + by * y + bz * z) - size / 2);
        if (left < 0 || top < 0 || left + size >= w || top + size >= h) continue;
        for (let v = top; v < top + size; v++) {
          for (let at = v * w + left, last = at + size; at < last; at++) {
            if (away < depth[at]) {
              depth[at] = away;
              color[at] = packed;
            }
          }
        }
      }
    }
    shade(w, h, focal, ratio);
    layerCtx.putImageData(image, 0, 0);
  }

  // Points carry no normals; the depths of the pixels around give both the slope, lit from the upper left, and
  // the edges, darkened by how much nearer the neighbours are (eye-dome lighting, Boucheny 2009).
  function shade(w, h, focal, ratio) {
    const step = Math.round(3 * ratio);
    const edge = 0.5 * eye.range / radius;
    const data = image.data;
    for (let v = step; v < h - step; v++) {
      for (let at = v * w + step, last = (v + 1) * w - step; at < last; at++) {
        const own = depth[at];
        if (own === Infinity) continue;
        const reach = own * step / focal;
        const right = rise(at + step, own, reach) - rise(at - step, own, reach);
        const up = rise(at - step * w, own, reach) - rise(at + step * w, own, reach);
        const facing = (0.8 + 0.35 * (up - right) / 2) / Math.sqrt(1 + (right * right + up * up) / 4);
        let hidden = 0;
        for (const next of [depth[at + step], depth[at - step], depth[at + step * w], depth[at - step * w]]) {
          if (next < own) hidden += 1 - next / own;
        }
        const light = (0.45 + 0.7 * Math.max(facing, 0)) * Math.exp(-edge * hidden);
        data[4 * at] *= light;
        data[4 * at + 1] *= light;
        data[4 * at + 2] *= light;
      }
    }
  }

  // The slope towards a pixel; level where there is another surface or none.
  function rise(at, own, reach) {
    const slope = (depth[at] - own) / reach;
    return Math.abs(slope) < 3 ? slope : 0;
  }

  function line(from, to, style, width, dash = []) {
    ctx.beginPath();
    ctx.moveTo(from.x, from.y);
    ctx.lineTo(to.x, to.y);
    ctx.strokeStyle = style;
    ctx.lineWidth = width;
    ctx.setLineDash(dash);
    ctx.stroke();
  }

  // 1, 2 or 5 times a power of ten.
  function roundStep(length) {
    const power = 10 ** Math.floor(Math.log10(length));
    return power * [5, 2, 1].find((m) => m * power <= length);
  }

  const gridStep = roundStep(radius);

  function drawGrid({ project }, ink, ratio) {
    const half = Math.ceil(2 * radius / gridStep);
    const [x0, y0] = [0, 1].map((k) => Math.round(center[k] / gridStep));
    ctx.globalAlpha = 0.22;
    for (let i = -half; i <= half; i++) {
      const at = (x, y) => project([(x0 + x) * gridStep, (y0 + y) * gridStep, low[2]]);
      line(at(i, -half), at(i, half), ink, ratio);
      line(at(-half, i), at(half, i), ink, ratio);
    }
    ctx.globalAlpha = 1;
  }

  // The way to a view, in short pieces, so that each can lie before or behind the points.
  function drawPath(view, { project }, inFront, ink, ratio) {
    for (let i = 1; i < view.path.length; i++) {
      const at = (t) => project(view.path[i].map((b, k) => view.path[i - 1][k] * (1 - t) + b * t));
      for (let piece = 0; piece < 8; piece++) {
        const [a, b] = [at(piece / 8), at((piece + 1) / 8)];
        if ((a.z < eye.range) === inFront) line(a, b, ink, 1.2 * ratio);
      }
    }
  }

  function drawCamera(view, number, { project }, inFront, ink, paper, ratio) {
    const apex = project(view.position);
    if ((apex.z < eye.range) !== inFront) return;
    const size = 0.13 * distance(view.position, center);
    const corners = view.corners.map((c) => project(c.map((d, k) => view.position[k] + size * d)));
    const style = `rgb(${view.color})`;
    corners.forEach((corner, i) => {
      line(apex, corner, style, 1.5 * ratio);
      line(corner, corners[(i + 1) % 4], style, 1.5 * ratio);
    });
    ctx.font = `600 ${12 * ratio}px system-ui, sans-serif`;
    ctx.strokeStyle = paper;
    ctx.lineWidth = 3 * ratio;
    ctx.strokeText(number, apex.x + 4 * ratio, apex.y - 4 * ratio);
    ctx.fillStyle = ink;
    ctx.fillText(number, apex.x + 4 * ratio, apex.y - 4 * ratio);
  }

  function drawCandidates({ project }, inFront, ink, ratio) {
    ctx.fillStyle = ink;
    ctx.globalAlpha = 0.5;
    for (const candidate of scene.candidates) {
      const p = project(candidate);
      if ((p.z < eye.range) === inFront) ctx.fillRect(p.x - ratio, p.y - ratio, 2 * ratio, 2 * ratio);
    }
    ctx.globalAlpha = 1;
  }

  function drawAxes({ rows }, ink, ratio) {
    const origin = { x: 36 * ratio, y: canvas.height - 36 * ratio };
    ctx.font = `${12 * ratio}px system-ui, sans-serif`;
    ctx.fillStyle = ink;
    ["x", "y", "z"].forEach((name, k) => {
      const tip = (length) => ({ x: origin.x + length * ratio * rows[0][k], y: origin.y - length * ratio * rows[1][k] });
      line(origin, tip(20), ink, 1.2 * ratio);
      const label = tip(28);
      ctx.fillText(name, label.x - 3 * ratio, label.y + 4 * ratio);
    });
    ctx.fillText(`grid ${+gridStep.toPrecision(1)} m`, 64 * ratio, canvas.height - 10 * ratio);
  }

  const slider = byId("slider");

  function draw() {
    const ratio = resize();
    const view = lens();
    const shown = Math.min(+slider.value, scene.views.length);
    byId("shown").value = shown;
    const { color: ink } = getComputedStyle(canvas);
    const paper = getComputedStyle(document.body).backgroundColor;
    ctx.clearRect(0, 0, canvas.width, canvas.height);
    drawGrid(view, ink, ratio);
    drawPoints(view, shown, ratio);
    for (const inFront of [false, true]) {
      if (inFront) ctx.drawImage(layer, 0, 0);
      drawCandidates(view, inFront, ink, ratio);
      scene.views.slice(0, shown).forEach((v) => drawPath(v, view, inFront, ink, ratio));
      scene.views.slice(0, shown).forEach((v, i) => drawCamera(v, i + 1, view, inFront, ink, paper, ratio));
    }
    drawAxes(view, ink, ratio);
  }

  let waiting = false;
  function redraw() {
    if (waiting) return;
    waiting = true;
    requestAnimationFrame(() => {
      waiting = false;
      draw();
    });
  }

  function turn(right, up) {
    eye.azimuth -= right;
    eye.elevation = Math.min(Math.max(eye.elevation + up, -1.55), 1.55);
    redraw();
  }

  function zoom(factor) {
    eye.range = Math.min(Math.max(eye.range * factor, 0.4 * radius), 20 * start.range);
    redraw();
  }

  // One pointer turns, two pointers zoom by their distance.
  const pointers = new Map();
  const spread = () => {
    const [a, b] = pointers.values();
    return Math.max(Math.hypot(a.x - b.x, a.y - b.y), 1);
  };
  canvas.addEventListener("pointerdown", (e) => {
    canvas.setPointerCapture(e.pointerId);
    pointers.set(e.pointerId, { x: e.clientX, y: e.clientY });
  });
  canvas.addEventListener("pointermove", (e) => {
    const before = pointers.get(e.pointerId);
    if (!before) return;
    const spreadBefore = pointers.size === 2 && spread();
    pointers.set(e.pointerId, { x: e.clientX, y: e.clientY });
    if (spreadBefore) zoom(spreadBefore / spread());
    else turn((e.clientX - before.x) * 0.008, (e.clientY - before.y) * 0.008);
  });
  for (const type of ["pointerup", "pointercancel"]) {
    canvas.addEventListener(type, (e) => pointers.delete(e.pointerId));
  }
  canvas.addEventListener("wheel", (e) => {
    e.preventDefault();
    zoom(Math.exp((e.deltaMode ? 30 : 1) * e.deltaY * 0.0015));
  }, { passive: false });
  canvas.addEventListener("dblclick", () => {
    eye = { ...start };
    redraw();
  });
  canvas.addEventListener("keydown", (e) => {
    const actions = {
      ArrowLeft: () => turn(-0.1, 0), ArrowRight: () => turn(0.1, 0),
      ArrowUp: () => turn(0, -0.1), ArrowDown: () => turn(0, 0.1),
      "+": () => zoom(0.9), "-": () => zoom(1 / 0.9),
    };
    if (!actions[e.key]) return;
    e.preventDefault();
    actions[e.key]();
  });
  slider.addEventListener("input", redraw);
  new ResizeObserver(redraw).observe(canvas);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);

  // Print in the colours of paper, and with the configuration that the screen folds away.
  const details = document.querySelector("details");
  let wasOpen = false;
  addEventListener("beforeprint", () => {
    wasOpen = details.open;
    details.open = true;
    draw();
  });
  addEventListener("afterprint", () => {
    details.open = wasOpen;
    redraw();
  });
  resize();
  fit();
  draw();
})();
