// A grid below the object, level, so wide as to stand around it.
function gridLines(scene, ink) {
  const { gridStep: step, axes } = scene;
  const half = Math.ceil(2 * scene.radius / step);
  const [x0, y0] = [0, 1].map((axis) => Math.round(dot(axes[axis], scene.center) / step));
  const low = Math.min(...cornersOf(scene.core).map((corner) => dot(axes[2], corner)));
  const color = [...ink, 60];
  const at = (x, y) => along(axes, [(x0 + x) * step, (y0 + y) * step, low]);
  const lines = [];
  for (let i = -half; i <= half; i++) {
    lines.push({ from: at(i, -half), to: at(i, half), color, width: 1 });
    lines.push({ from: at(-half, i), to: at(half, i), color, width: 1 });
  }
  return lines;
}
