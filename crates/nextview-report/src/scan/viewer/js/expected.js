// Unseen surface as the prior expects it: a translucent shell, denser where it is seen from the side.
const EXPECTED_VERTEX = `
in vec3 position, normal;
uniform mat4 clip;
out vec3 direction, place;
void main() { gl_Position = clip * vec4(position, 1.0); direction = normal; place = position; }`;
const EXPECTED_FRAGMENT = `
in vec3 direction, place;
uniform vec3 eye, tint;
out vec4 pixel;
void main() {
  float facing = dot(normalize(direction), normalize(eye - place));
  float alpha = 0.16 + 0.5 * pow(1.0 - clamp(facing, 0.0, 1.0), 2.0);
  pixel = vec4(tint * alpha, alpha);
}`;
const EXPECTED_COLOR = [132, 92, 214];

function expectedLayer(gl) {
  const shell = program(gl, EXPECTED_VERTEX, EXPECTED_FRAGMENT);
  return {
    load: ({ positions, triangles }) => {
      const vertices = positionsOf(positions);
      const indices = indicesOf(triangles);
      const attributes = [["position", vertices, 3], ["normal", normalsOf(vertices, indices), 3]];
      return { ...arrays(gl, shell, attributes, indices), count: indices.length };
    },
    // After all that is opaque. Only the front side is drawn, so that it covers once.
    draw: (buffers, view) => {
      shell.use();
      shell.matrix("clip", view.clip);
      shell.vector("eye", view.position);
      shell.colors("tint", [EXPECTED_COLOR]);
      gl.depthMask(false);
      gl.enable(gl.CULL_FACE);
      buffers.bind();
      gl.drawElements(gl.TRIANGLES, buffers.count, gl.UNSIGNED_INT, 0);
      gl.bindVertexArray(null);
      gl.disable(gl.CULL_FACE);
      gl.depthMask(true);
    },
  };
}
