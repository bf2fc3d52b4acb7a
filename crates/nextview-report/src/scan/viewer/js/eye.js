// The eye goes around a target.
const FIELD = Math.tan(Math.PI / 11); // half of the field of view over the shorter side
const MARGIN = 0.9;

// Three axes, right-handed, of which the third points up; those of the world where that is z.
function axesOf(up) {
  const away = minus([1, 0, 0], [up[0] * up[0], up[0] * up[1], up[0] * up[2]]);
  const level = length(away) > 0.1 ? away : minus([0, 1, 0], [up[1] * up[0], up[1] * up[1], up[1] * up[2]]);
  const x = plus([0, 0, 0], level, 1 / length(level));
  return [x, [up[1] * x[2] - up[2] * x[1], up[2] * x[0] - up[0] * x[2], up[0] * x[1] - up[1] * x[0]], up];
}

const along = (axes, [x, y, z]) => plus(plus(plus([0, 0, 0], axes[0], x), axes[1], y), axes[2], z);

function rowsOf({ azimuth, elevation, axes }) {
  const [sa, ca, se, ce] = [Math.sin(azimuth), Math.cos(azimuth), Math.sin(elevation), Math.cos(elevation)];
  return [[-sa, ca, 0], [-se * ca, -se * sa, ce], [ce * ca, ce * sa, se]].map((row) => along(axes, row));
}

// What is needed to draw from an eye: the directions right, up and towards the eye, its position, the matrix
// to clip space by columns, the pixels per metre at a distance of one metre, and the place of points in pixels.
function viewFrom(eye, size, ratio) {
  const rows = rowsOf(eye);
  const position = plus(eye.target, rows[2], eye.range);
  const focal = Math.min(...size) / 2 / FIELD;
  const [sx, sy] = size.map((side) => 2 * focal / side);
  const [near, far] = [0.02 * eye.range, 60 * eye.range];
  const [p, q] = [(far + near) / (far - near), 2 * far * near / (far - near)];
  const [x, y, z] = rows.map((row) => -dot(row, position));
  const [r, u, b] = rows;
  const column = (k) => [sx * r[k], sy * u[k], -p * b[k], -b[k]];
  const clip = Float32Array.from([...column(0), ...column(1), ...column(2), sx * x, sy * y, -p * z - q, -z]);
  const project = (point) => {
    const away = minus(point, position);
    const depth = -dot(away, rows[2]);
    const scale = focal / Math.max(depth, 1e-6);
    return { x: size[0] / 2 + scale * dot(away, r), y: size[1] / 2 - scale * dot(away, u), depth };
  };
  return { rows, position, clip, focal, size, ratio, project };
}

// Moves the eye back and its target sideways until these points fill the picture.
function framing(eye, points, size) {
  let framed = { ...eye };
  if (!points.length) return framed;
  const rows = rowsOf(eye);
  const spread = Math.max(...points.map((point) => distance(point, eye.target)), 1e-3);
  framed.range = 4 * spread / FIELD;
  for (let round = 0; round < 10; round++) {
    const view = viewFrom(framed, size, 1);
    const places = points.map(view.project);
    const [xs, ys] = [places.map((p) => p.x / size[0]), places.map((p) => p.y / size[1])];
    const [left, right, top, bottom] = [Math.min(...xs), Math.max(...xs), Math.min(...ys), Math.max(...ys)];
    const metres = framed.range / view.focal;
    framed.target = plus(framed.target, rows[0], ((left + right) / 2 - 0.5) * size[0] * metres);
    framed.target = plus(framed.target, rows[1], (0.5 - (top + bottom) / 2) * size[1] * metres);
    framed.range *= Math.max(right - left, bottom - top, 1e-3) / MARGIN;
  }
  return framed;
}
