// The arrays of a scene, which stand in it as base64.
const bytesOf = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0));

// Three coordinates each, 16 bits little-endian, as is every machine that runs a browser.
function positionsOf({ min, unit, data }) {
  const steps = new Uint16Array(bytesOf(data).buffer);
  const positions = new Float32Array(steps.length);
  for (let i = 0; i < steps.length; i++) positions[i] = min[i % 3] + steps[i] * unit[i % 3];
  return positions;
}

// Differences to the index before, seven bits a byte, the sign in the lowest bit.
function indicesOf(data) {
  const bytes = bytesOf(data);
  const indices = new Uint32Array(bytes.length);
  let n = 0, index = 0, at = 0;
  while (at < bytes.length) {
    let step = 0, shift = 0, byte;
    do {
      byte = bytes[at++];
      step |= (byte & 127) << shift;
      shift += 7;
    } while (byte > 127);
    index += (step >>> 1) ^ -(step & 1);
    indices[n++] = index;
  }
  return indices.slice(0, n);
}

// By vertex, the mean normal of its triangles by area.
function normalsOf(positions, triangles) {
  const normals = new Float32Array(positions.length);
  const corner = (i) => [positions[3 * i], positions[3 * i + 1], positions[3 * i + 2]];
  for (let t = 0; t < triangles.length; t += 3) {
    const [a, b, c] = [corner(triangles[t]), corner(triangles[t + 1]), corner(triangles[t + 2])];
    const [u, v] = [minus(b, a), minus(c, a)];
    const normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    for (let k = 0; k < 3; k++) {
      for (let axis = 0; axis < 3; axis++) normals[3 * triangles[t + k] + axis] += normal[axis];
    }
  }
  for (let i = 0; i < normals.length; i += 3) {
    const size = Math.hypot(normals[i], normals[i + 1], normals[i + 2]) || 1;
    for (let axis = 0; axis < 3; axis++) normals[i + axis] /= size;
  }
  return normals;
}
