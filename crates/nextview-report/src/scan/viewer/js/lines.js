// Lines of any width: each is a rectangle on the screen.
const LINE_VERTEX = `
in vec3 from, to; in vec4 color; in float width;
uniform mat4 clip; uniform vec2 size;
out vec4 tint;
const vec2 CORNERS[6] = vec2[6](vec2(0,-1), vec2(1,-1), vec2(1,1), vec2(0,-1), vec2(1,1), vec2(0,1));
void main() {
  vec4 a = clip * vec4(from, 1.0), b = clip * vec4(to, 1.0);
  // What lies behind the eye is cut off.
  float near = 1e-4;
  if (a.w < near && b.w > near) a = mix(a, b, (near - a.w) / (b.w - a.w));
  if (b.w < near && a.w > near) b = mix(b, a, (near - b.w) / (a.w - b.w));
  vec2 along = (b.xy / b.w - a.xy / a.w) * size;
  vec2 across = length(along) > 1e-6 ? normalize(vec2(-along.y, along.x)) : vec2(0.0, 1.0);
  vec2 corner = CORNERS[gl_VertexID % 6];
  gl_Position = corner.x < 0.5 ? a : b;
  gl_Position.xy += corner.y * across * width / size * gl_Position.w;
  if (a.w < near && b.w < near) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
  tint = vec4(color.rgb * color.a, color.a);
}`;
const LINE_FRAGMENT = `
in vec4 tint; out vec4 pixel;
void main() { pixel = tint; }`;

function lineLayer(gl) {
  const lines = program(gl, LINE_VERTEX, LINE_FRAGMENT);
  // Lines as {from, to, color: [r, g, b, a] in 0..=255, width in pixels of the page}.
  return (list, view) => {
    if (!list.length) return;
    lines.use();
    lines.matrix("clip", view.clip);
    lines.pair("size", view.size);
    const buffers = arrays(gl, lines, [
      ["from", Float32Array.from(list.flatMap((l) => l.from)), 3, 1],
      ["to", Float32Array.from(list.flatMap((l) => l.to)), 3, 1],
      ["color", Uint8Array.from(list.flatMap((l) => l.color)), 4, 1],
      ["width", Float32Array.from(list, (l) => l.width * view.ratio), 1, 1],
    ]);
    buffers.bind();
    gl.drawArraysInstanced(gl.TRIANGLES, 0, 6, list.length);
    gl.bindVertexArray(null);
    buffers.free();
  };
}
