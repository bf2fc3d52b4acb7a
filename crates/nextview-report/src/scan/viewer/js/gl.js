// A thin layer over WebGL 2.

// None where the browser has no WebGL 2. The drawing is kept for print.
function startGl(canvas) {
  const gl = canvas.getContext && canvas.getContext("webgl2", { antialias: true, preserveDrawingBuffer: true });
  return gl && !gl.isContextLost() ? gl : null;
}

function compile(gl, kind, source) {
  const shader = gl.createShader(kind);
  gl.shaderSource(shader, "#version 300 es\nprecision highp float;\nprecision highp int;\n" + source);
  gl.compileShader(shader);
  if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
  return shader;
}

// A program whose uniforms are set by name.
function program(gl, vertexSource, fragmentSource) {
  const handle = gl.createProgram();
  gl.attachShader(handle, compile(gl, gl.VERTEX_SHADER, vertexSource));
  gl.attachShader(handle, compile(gl, gl.FRAGMENT_SHADER, fragmentSource));
  gl.linkProgram(handle);
  if (!gl.getProgramParameter(handle, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(handle));
  const place = (name) => gl.getUniformLocation(handle, name);
  return {
    use: () => gl.useProgram(handle),
    attribute: (name) => gl.getAttribLocation(handle, name),
    number: (name, value) => gl.uniform1f(place(name), value),
    pair: (name, value) => gl.uniform2fv(place(name), value),
    vector: (name, value) => gl.uniform3fv(place(name), value),
    colors: (name, value) => gl.uniform3fv(place(name), value.flat().map((c) => c / 255)),
    matrix: (name, value) => gl.uniformMatrix4fv(place(name), false, value),
  };
}

// Buffers of one drawing: attributes as [name, data, numbers each, per instance]; bytes are shares of 255.
function arrays(gl, of, attributes, indices) {
  const handle = gl.createVertexArray();
  gl.bindVertexArray(handle);
  const buffers = attributes.map(([name, data, size, divisor = 0]) => {
    const buffer = gl.createBuffer();
    const at = of.attribute(name);
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, data, gl.STATIC_DRAW);
    const isBytes = data instanceof Uint8Array;
    if (at >= 0) {
      gl.enableVertexAttribArray(at);
      gl.vertexAttribPointer(at, size, isBytes ? gl.UNSIGNED_BYTE : gl.FLOAT, isBytes, 0, 0);
      gl.vertexAttribDivisor(at, divisor);
    }
    return buffer;
  });
  if (indices) {
    buffers.push(gl.createBuffer());
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, buffers[buffers.length - 1]);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, indices, gl.STATIC_DRAW);
  }
  gl.bindVertexArray(null);
  return {
    bind: () => gl.bindVertexArray(handle),
    free: () => {
      buffers.forEach((buffer) => gl.deleteBuffer(buffer));
      gl.deleteVertexArray(handle);
    },
  };
}
