// Vectors of three, matrices by their rows, and lines that are made of two places: as shapes.py has them.
const unit = a => { const n = Math.hypot(...a) || 1; return a.map(x => x / n); };
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const times = (A, v) => A.map(row => dot(row, v)), plus = (a, b) => a.map((x, i) => x + b[i]), scaled = (a, k) => a.map(x => k * x);
const product = (A, B) => A.map(row => [0, 1, 2].map(j => row[0] * B[0][j] + row[1] * B[1][j] + row[2] * B[2][j]));
function turn_of(q) {  // of a quaternion
  const n = Math.hypot(q[0], q[1], q[2], q[3]) || 1, w = q[0] / n, x = q[1] / n, y = q[2] / n, z = q[3] / n;
  return [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)], [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)], [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]];
}
function coil(a, b, radius, turns) {  // as shapes.py does it
  const way = b.map((x, i) => x - a[i]), n = Math.hypot(...way), z = n > 0 ? way.map(x => x / n) : [0, 0, 1], x = unit(cross(Math.abs(z[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0], z)), y = cross(z, x), found = [a], steps = 12 * turns;
  for (let k = 0; k <= steps; k++) { const s = 0.12 + 0.76 * k / steps, u = 2 * Math.PI * turns * k / steps, c = radius * Math.cos(u), d = radius * Math.sin(u); found.push(a.map((p, i) => p + s * way[i] + c * x[i] + d * y[i])); }
  found.push(b); return found;
}
