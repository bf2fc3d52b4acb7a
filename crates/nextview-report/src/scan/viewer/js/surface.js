// The measured surface, shaded, in one of four colourings.
const SURFACE_VERTEX = `
in vec3 position, normal, looks, color;
uniform mat4 clip; uniform float shown;
out vec3 direction, place, seen, own; out float hidden;
void main() {
  gl_Position = clip * vec4(position, 1.0);
  direction = normal; place = position; seen = looks; own = color;
  hidden = looks.z * 255.0 >= shown ? 1.0 : 0.0;
}`;
const SURFACE_FRAGMENT = `
in vec3 direction, place, seen, own; in float hidden;
uniform float colouring, n_views; uniform vec3 eye, right, up, zenith;
uniform vec3 views[6]; uniform vec3 confidence[5];
out vec4 pixel;
vec3 fromLow(float t) {
  float at = clamp(t, 0.0, 1.0) * 4.0; int low = int(min(floor(at), 3.0));
  return mix(confidence[low], confidence[low + 1], at - float(low));
}
vec3 ofView(float t) {
  float at = clamp(t, 0.0, 1.0) * 5.0; int low = int(min(floor(at), 4.0));
  return mix(views[low], views[low + 1], at - float(low));
}
void main() {
  if (hidden > 0.01) discard;
  vec3 outward = normalize(direction), back = normalize(eye - place);
  vec3 base = vec3(0.80, 0.795, 0.78);
  if (colouring > 2.5) base = ofView(seen.z * 255.0 / max(n_views - 1.0, 1.0));
  else if (colouring > 1.5) {
    // Half of what is missing comes with every look; a flat look counts little.
    float often = 1.0 - exp2(-seen.x * 255.0);
    base = fromLow(often * clamp((seen.y - 0.1) / 0.75, 0.0, 1.0));
  } else if (colouring > 0.5) base = own;
  // The side that no camera can see is the inside.
  bool inside = dot(outward, back) < 0.0;
  if (inside) { outward = -outward; base = mix(base, vec3(0.36, 0.34, 0.38), 0.75); }
  vec3 key = normalize(back + 0.55 * up - 0.45 * right);
  float light = 0.34 + 0.22 * (0.5 + 0.5 * dot(outward, zenith)) + 0.52 * max(dot(outward, key), 0.0);
  float gloss = pow(max(dot(outward, normalize(key + back)), 0.0), 24.0);
  float rim = pow(1.0 - max(dot(outward, back), 0.0), 3.0);
  pixel = vec4(base * (light - 0.18 * rim) + (inside ? 0.0 : 0.07) * gloss, 1.0);
}`;

const COLOURINGS = ["shape", "colour", "confidence", "first view"];
// From never seen well to seen often and from the front: readable without red and green.
const CONFIDENCE = [[94, 24, 110], [62, 84, 150], [34, 146, 140], [112, 200, 98], [246, 226, 62]];

function surfaceLayer(gl) {
  const surface = program(gl, SURFACE_VERTEX, SURFACE_FRAGMENT);
  return {
    load: ({ positions, triangles, looks, colors }) => {
      const vertices = positionsOf(positions);
      const indices = indicesOf(triangles);
      const buffers = arrays(gl, surface, [
        ["position", vertices, 3],
        ["normal", normalsOf(vertices, indices), 3],
        ["looks", bytesOf(looks), 3],
        ["color", colors ? bytesOf(colors) : new Uint8Array(vertices.length).fill(200), 3],
      ], indices);
      return { ...buffers, count: indices.length, hasColors: colors !== "" };
    },
    draw: (buffers, view, { colouring, shown, nViews, ramp, zenith }) => {
      surface.use();
      surface.matrix("clip", view.clip);
      surface.vector("eye", view.position);
      surface.vector("right", view.rows[0]);
      surface.vector("up", view.rows[1]);
      surface.vector("zenith", zenith);
      surface.colors("views", ramp);
      surface.colors("confidence", CONFIDENCE);
      surface.number("colouring", COLOURINGS.indexOf(colouring));
      surface.number("n_views", nViews);
      surface.number("shown", shown >= nViews ? 1000 : shown);
      buffers.bind();
      gl.drawElements(gl.TRIANGLES, buffers.count, gl.UNSIGNED_INT, 0);
      gl.bindVertexArray(null);
    },
  };
}
