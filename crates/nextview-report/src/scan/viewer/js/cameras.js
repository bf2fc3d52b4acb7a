// Cameras as small frusta, the path between them, candidates as dots.
function frustum(camera, size, color, width) {
  const corners = camera.corners.map((corner) => plus(camera.position, corner, size));
  const line = (from, to) => ({ from, to, color, width });
  return corners.flatMap((corner, i) => [line(camera.position, corner), line(corner, corners[(i + 1) % 4])]);
}

function pathLines(view, color, width) {
  return view.path.slice(1).map((to, i) => ({ from: view.path[i], to, color, width }));
}

// As large as it looks well beside the object.
const frustumSize = (camera, scene) => 0.1 * Math.max(distance(camera.position, scene.center), scene.radius);

function cameraLines(scene, shown, ink) {
  const lines = [];
  scene.views.slice(0, shown).forEach((view, i) => {
    const color = [...onRamp(scene.ramp, i / Math.max(scene.nViews - 1, 1)), 255];
    lines.push(...frustum(view, frustumSize(view, scene), color, 1.6));
    lines.push(...pathLines(view, [...ink, 130], 1.2));
  });
  return lines;
}

const NEXT_COLOR = [236, 108, 22, 255];
const CURRENT_COLOR = [20, 150, 90, 255];

// The proposed view, with the rays through the corners of its image on to the object.
function nextLines(scene) {
  const { next } = scene;
  if (!next) return [];
  const reach = distance(next.position, scene.center);
  const rays = next.corners.map((corner) => ({
    from: next.position, to: plus(next.position, corner, reach), color: [...NEXT_COLOR.slice(0, 3), 90], width: 1,
  }));
  return [...frustum(next, 1.5 * frustumSize(next, scene), NEXT_COLOR, 3), ...rays];
}

// The camera in the hand, and the way from there to the proposed view.
function currentLines(scene) {
  if (!scene.current) return [];
  const lines = frustum(scene.current, frustumSize(scene.current, scene), CURRENT_COLOR, 2.4);
  if (scene.next) lines.push({ from: scene.current.position, to: scene.next.position, color: CURRENT_COLOR, width: 2.4 });
  return lines;
}
