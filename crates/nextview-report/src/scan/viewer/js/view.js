// The 3D view: a scene, an eye, and what is drawn.
function startView(gl, canvas, labelCanvas) {
  const [drawLines, points, surface, expected] = [lineLayer(gl), pointLayer(gl), surfaceLayer(gl), expectedLayer(gl)];
  const drawLabels = labelLayer(labelCanvas);
  const scene = {
    views: [], nViews: 0, next: null, current: null, chunks: [], surface: null, expected: null, candidates: null,
    core: [[-0.1, -0.1, 0], [0.1, 0.1, 0.2]], center: [0, 0, 0.1], radius: 0.2, gridStep: 0.05, ramp: [],
    axes: axesOf([0, 0, 1]),
  };
  const show = {
    surface: true, points: false, expected: true, cameras: true, candidates: false, colouring: "shape", shown: Infinity,
  };
  let eye = { azimuth: -0.9, elevation: 0.4, range: 1, target: scene.center, axes: scene.axes };
  let start = eye;
  let isMoved = false;
  let isWaiting = false;

  function size() {
    const ratio = Math.min(window.devicePixelRatio || 1, 2);
    const sides = [canvas.clientWidth, canvas.clientHeight].map((side) => Math.max(1, Math.round(side * ratio)));
    if (canvas.width !== sides[0] || canvas.height !== sides[1]) [canvas.width, canvas.height] = sides;
    return { sides, ratio };
  }

  // Looks at the object from the side from which most cameras did.
  function startingEye() {
    const sum = scene.views.reduce((sum, v) => plus(sum, minus(v.position, scene.center)), [0, 0, 0]);
    const reach = scene.views.reduce((reach, v) => reach + distance(v.position, scene.center), 0);
    const [x, y] = scene.axes.map((axis) => dot(axis, sum));
    const azimuth = Math.hypot(x, y) > 0.3 * reach ? Math.atan2(y, x) - 0.3 : -0.9;
    return { azimuth, elevation: 0.4, range: 1, target: scene.center, axes: scene.axes };
  }

  function reset() {
    // Before the first view, there is nothing but the camera that is to take it.
    const first = scene.nViews === 0 && scene.next ? [scene.next.position] : [];
    start = framing(startingEye(), cornersOf(scene.core).concat(first), size().sides);
    [eye, isMoved] = [{ ...start }, false];
    redraw();
  }

  function frameCameras() {
    const places = [...scene.views, scene.next, scene.current].filter(Boolean).map((v) => v.position);
    eye = framing({ ...eye, target: scene.center }, cornersOf(scene.core).concat(places), size().sides);
    isMoved = true;
    redraw();
  }

  function dots() {
    const { places, gains } = scene.candidates;
    const colors = Uint8Array.from({ length: places.length }, (_, i) => 150);
    gains.forEach((gain, i) => colors.set(onRamp(CONFIDENCE, gain / 255), 3 * i));
    return points.load(places, colors);
  }

  // Takes in a scene, or what is new in it.
  function load(data) {
    if (data.after === 0) {
      scene.chunks.forEach((chunk) => chunk.buffers.free());
      scene.chunks = [];
    }
    // Poses of all, paths of the new ones.
    scene.views = data.views.map((view, i) => i < data.after ? { ...view, path: scene.views[i].path } : view);
    [scene.nViews, scene.next] = [data.n_views, data.next];
    [scene.ramp, scene.core, scene.axes] = [data.ramp, data.core, axesOf(data.up)];
    scene.center = mix(data.core[0], data.core[1], 0.5);
    scene.radius = Math.max(distance(data.core[0], data.core[1]) / 2, 0.005);
    scene.gridStep = roundStep(scene.radius / 2);
    const positions = positionsOf(data.points);
    if (positions.length) {
      scene.chunks.push({ positions, ends: data.ends, after: data.after, buffers: null });
    }
    colorPoints();
    for (const part of ["surface", "expected"]) {
      if (scene[part]) scene[part].free();
      scene[part] = data[part] && (part === "surface" ? surface : expected).load(data[part]);
    }
    if (scene.candidates) scene.candidates.buffers.free();
    scene.candidates = {
      places: positionsOf(data.candidates.positions), gains: bytesOf(data.candidates.gains), best: data.candidates.best,
    };
    scene.candidates.buffers = dots();
    if (isMoved) eye.axes = scene.axes;
    else reset();
    redraw();
  }

  // Points have the colour of the view that saw them first, which depends on the number of views.
  function colorPoints() {
    for (const chunk of scene.chunks) {
      const colors = new Uint8Array(chunk.positions.length);
      let from = 0;
      chunk.ends.forEach((end, i) => {
        const color = onRamp(scene.ramp, (chunk.after + i) / Math.max(scene.nViews - 1, 1));
        for (let at = 3 * from; at < 3 * end; at += 3) colors.set(color, at);
        from = end;
      });
      if (chunk.buffers) chunk.buffers.free();
      chunk.buffers = points.load(chunk.positions, colors);
    }
  }

  function drawPoints(view) {
    const n = scene.chunks.reduce((n, chunk) => n + chunk.positions.length / 3, 0);
    // As wide as the distance between neighbours if the points lay evenly on a ball.
    const spacing = 3.2 * scene.radius / Math.sqrt(Math.max(n, 1));
    for (const { buffers, ends, after } of scene.chunks) {
      const count = clamp(show.shown - after, 0, ends.length);
      points.draw(buffers, 0, count ? ends[count - 1] : 0, spacing, view, [1.2, 7]);
    }
  }

  function draw() {
    const { sides, ratio } = size();
    const view = viewFrom(eye, sides, ratio);
    const style = getComputedStyle(canvas);
    const ink = style.color.match(/\d+/g).slice(0, 3).map(Number);
    const shown = Math.min(show.shown, scene.nViews);
    gl.viewport(0, 0, ...sides);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    drawLines(gridLines(scene, ink), view);
    const hasSurface = scene.surface && show.surface;
    if (hasSurface) surface.draw(scene.surface, view, { ...show, shown, nViews: scene.nViews, ramp: scene.ramp, zenith: scene.axes[2] });
    if (show.points || (show.surface && !scene.surface)) drawPoints(view);
    if (show.candidates) {
      points.draw(scene.candidates.buffers, 0, scene.candidates.places.length / 3, 0.05 * scene.radius, view, [4, 9]);
    }
    if (show.cameras) drawLines(cameraLines(scene, shown, ink), view);
    drawLines(nextLines(scene).concat(currentLines(scene)), view);
    if (scene.expected && show.expected && shown === scene.nViews) expected.draw(scene.expected, view);
    const paper = getComputedStyle(document.body).backgroundColor;
    drawLabels(scene, view, { shown, cameras: show.cameras, ink: style.color, paper });
  }

  function redraw() {
    if (isWaiting) return;
    isWaiting = true;
    requestAnimationFrame(() => {
      isWaiting = false;
      draw();
    });
  }

  function move(change) {
    change(eye);
    eye.elevation = clamp(eye.elevation, -1.55, 1.55);
    eye.range = clamp(eye.range, 0.25 * scene.radius, 60 * scene.radius);
    isMoved = true;
    redraw();
  }

  // By pixels of the page.
  function pan(right, up) {
    const { sides, ratio } = size();
    const metres = eye.range * ratio / viewFrom(eye, sides, ratio).focal;
    const rows = rowsOf(eye);
    move(() => { eye.target = plus(plus(eye.target, rows[0], -right * metres), rows[1], up * metres); });
  }

  function moveCamera(camera) {
    scene.current = camera;
    redraw();
  }

  function resized() {
    if (isMoved) redraw();
    else reset();
  }

  return { scene, show, load, moveCamera, resized, draw, redraw, reset, frameCameras, move, pan };
}
