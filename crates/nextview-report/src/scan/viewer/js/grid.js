// A grid below the object, so wide as to stand around it.
function gridLines(scene, ink) {
  const step = scene.gridStep;
  const half = Math.ceil(2 * scene.radius / step);
  const [x0, y0] = [0, 1].map((axis) => Math.round(scene.center[axis] / step));
  const color = [...ink, 60];
  const at = (x, y) => [(x0 + x) * step, (y0 + y) * step, scene.core[0][2]];
  const lines = [];
  for (let i = -half; i <= half; i++) {
    lines.push({ from: at(i, -half), to: at(i, half), color, width: 1 });
    lines.push({ from: at(-half, i), to: at(half, i), color, width: 1 });
  }
  return lines;
}
