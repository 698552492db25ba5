// Arrays from text, and vectors, quaternions (x, y, z, w) and matrices (columns first).

const bytesOf = (text) => {
  const raw = atob(text);
  const bytes = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; i += 1) bytes[i] = raw.charCodeAt(i);
  return bytes.buffer;
};
const floats = (text) => new Float32Array(bytesOf(text));
const shorts = (text) => new Int16Array(bytesOf(text));

const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
const subtract = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const scaled = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const norm = (a) => Math.hypot(a[0], a[1], a[2]);
const unit = (a) => scaled(a, 1 / (norm(a) || 1));

// The vector `v` rotated by the quaternion `q`.
const turned = (q, v) => {
  const t = scaled(cross(q, v), 2);
  return add(add(v, scaled(t, q[3])), cross(q, t));
};

// The rotation by `b`, then by `a`.
const product = (a, b) => [
  a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1],
  a[3] * b[1] - a[0] * b[2] + a[1] * b[3] + a[2] * b[0],
  a[3] * b[2] + a[0] * b[1] - a[1] * b[0] + a[2] * b[3],
  a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2],
];

// The rotation of the z axis to the unit vector `v`.
const turnFromZ = (v) => {
  if (v[2] < -0.999999) return [1, 0, 0, 0];
  const q = [-v[1], v[0], 0, 1 + v[2]];
  const length = Math.hypot(...q);
  return q.map((x) => x / length);
};

// The matrix of a placement after a scaling of the axes.
const placed = (position, q, scale, out = new Float32Array(16)) => {
  const [x, y, z, w] = q;
  const [a, b, c] = scale;
  out[0] = (1 - 2 * (y * y + z * z)) * a;
  out[1] = 2 * (x * y + z * w) * a;
  out[2] = 2 * (x * z - y * w) * a;
  out[4] = 2 * (x * y - z * w) * b;
  out[5] = (1 - 2 * (x * x + z * z)) * b;
  out[6] = 2 * (y * z + x * w) * b;
  out[8] = 2 * (x * z + y * w) * c;
  out[9] = 2 * (y * z - x * w) * c;
  out[10] = (1 - 2 * (x * x + y * y)) * c;
  out[12] = position[0];
  out[13] = position[1];
  out[14] = position[2];
  out[15] = 1;
  return out;
};

const times = (a, b) => {
  const out = new Float32Array(16);
  for (let i = 0; i < 4; i += 1) {
    for (let j = 0; j < 4; j += 1) {
      let sum = 0;
      for (let k = 0; k < 4; k += 1) sum += a[k * 4 + i] * b[j * 4 + k];
      out[j * 4 + i] = sum;
    }
  }
  return out;
};

const lookAt = (eye, target, up) => {
  const z = unit(subtract(eye, target));
  const x = unit(cross(up, z));
  const y = cross(z, x);
  return new Float32Array([
    x[0], y[0], z[0], 0, x[1], y[1], z[1], 0, x[2], y[2], z[2], 0,
    -dot(x, eye), -dot(y, eye), -dot(z, eye), 1,
  ]);
};

const perspective = (fovY, aspect, near, far) => {
  const f = 1 / Math.tan(fovY / 2);
  const d = 1 / (near - far);
  return new Float32Array([f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (near + far) * d, -1, 0, 0, 2 * near * far * d, 0]);
};

const orthographic = (half, near, far) => new Float32Array([
  1 / half, 0, 0, 0, 0, 1 / half, 0, 0, 0, 0, 2 / (near - far), 0, 0, 0, (near + far) / (near - far), 1,
]);
