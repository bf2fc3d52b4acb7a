// Vectors of three numbers.
const plus = (a, b, t = 1) => [a[0] + t * b[0], a[1] + t * b[1], a[2] + t * b[2]];
const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const length = (a) => Math.hypot(a[0], a[1], a[2]);
const distance = (a, b) => length(minus(a, b));
const mix = (a, b, t) => plus([a[0] * (1 - t), a[1] * (1 - t), a[2] * (1 - t)], b, t);
const clamp = (x, low, high) => Math.min(Math.max(x, low), high);

// The corners of a box between two of them.
const cornersOf = (box) => [...Array(8).keys()].map((i) => [0, 1, 2].map((k) => box[i >> k & 1][k]));

// 1, 2 or 5 times a power of ten, no more than this.
function roundStep(size) {
  const power = 10 ** Math.floor(Math.log10(size));
  return power * [5, 2, 1].find((m) => m * power <= size * 1.0001);
}

// A length in metres as people say it.
function lengthText(metres) {
  const digits = (value) => String(+value.toPrecision(2));
  if (metres >= 1) return `${digits(metres)} m`;
  return metres >= 0.01 ? `${digits(100 * metres)} cm` : `${digits(1000 * metres)} mm`;
}

// The colour at t in 0..=1 on a ramp of evenly spaced colours.
function onRamp(ramp, t) {
  const at = clamp(t, 0, 1) * (ramp.length - 1);
  const low = Math.min(Math.floor(at), ramp.length - 2);
  return mix(ramp[low], ramp[low + 1], at - low).map(Math.round);
}
