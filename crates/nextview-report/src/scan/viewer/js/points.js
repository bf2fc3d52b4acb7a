// Points as small balls.
const POINT_VERTEX = `
in vec3 position; in vec3 color;
uniform mat4 clip; uniform float spacing; uniform vec2 limits;
out vec3 tint;
void main() {
  gl_Position = clip * vec4(position, 1.0);
  gl_PointSize = clamp(spacing / max(gl_Position.w, 1e-6), limits.x, limits.y);
  tint = color;
}`;
const POINT_FRAGMENT = `
in vec3 tint; out vec4 pixel;
void main() {
  vec2 at = 2.0 * gl_PointCoord - 1.0;
  float out2 = dot(at, at);
  if (out2 > 1.0) discard;
  float facing = dot(vec3(at.x, -at.y, sqrt(1.0 - out2)), vec3(-0.3, 0.45, 0.84));
  pixel = vec4(tint * (0.62 + 0.42 * max(facing, 0.0)), 1.0);
}`;

// Draws balls of one buffer; `size` is their distance in metres.
function pointLayer(gl) {
  const points = program(gl, POINT_VERTEX, POINT_FRAGMENT);
  return {
    load: (positions, colors) => arrays(gl, points, [["position", positions, 3], ["color", colors, 3]]),
    draw: (buffers, first, count, size, view, limits) => {
      if (!count) return;
      points.use();
      points.matrix("clip", view.clip);
      points.number("spacing", size * view.focal);
      points.pair("limits", limits.map((limit) => limit * view.ratio));
      buffers.bind();
      gl.drawArrays(gl.POINTS, first, count);
      gl.bindVertexArray(null);
    },
  };
}
