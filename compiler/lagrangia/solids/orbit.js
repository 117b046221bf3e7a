// A scene in space: solids and lines, seen from far away; turned, shifted and zoomed by hand.
for (const b of D.bodies) { b.v = F(b.v); b.poses = F(b.poses); b.low = Infinity; }
for (const l of D.lines) l.points = F(l.points);
for (const c of D.captions) c.at = F(c.at);
for (const t of D.traces) t.at = F(t.at);
const unit = a => { const n = Math.hypot(...a) || 1; return a.map(x => x / n); };
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const UP = unit(D.up), EAST = (() => { const k = UP.map(Math.abs).indexOf(Math.min(...UP.map(Math.abs))), e = [0, 0, 0]; e[k] = 1; const a = dot(e, UP); return unit(e.map((x, i) => x - a * UP[i])); })(), NORTH = cross(UP, EAST);
const middle = D.low.map((x, i) => (x + D.high[i]) / 2), reach = Math.hypot(...D.low.map((x, i) => D.high[i] - x)) || 1;
const START = { azimuth: -60 * Math.PI / 180, elevation: 22 * Math.PI / 180, zoom: 1, x: 0, y: 0 };
let eye = { ...START };

function axes() {  // to the right, upwards, towards the eye
  const c = Math.cos(eye.azimuth), s = Math.sin(eye.azimuth), e = Math.cos(eye.elevation), z = Math.sin(eye.elevation);
  const level = EAST.map((x, i) => c * x + s * NORTH[i]), forth = level.map((x, i) => e * x + z * UP[i]), right = cross(UP, level);
  return [right, cross(forth, right), forth];
}
const scale_of = (w, h) => eye.zoom * Math.min(w, h) / reach;
function turn_of(q) {  // a matrix, by rows
  const n = Math.hypot(q[0], q[1], q[2], q[3]) || 1, w = q[0] / n, x = q[1] / n, y = q[2] / n, z = q[3] / n;
  return [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)], [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)], [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]];
}
function pose_of(b, i, j, f) {
  const p = [], a = 7 * i, c = 7 * j; let same = 0;
  for (let k = 3; k < 7; k++) same += b.poses[a + k] * b.poses[c + k];
  for (let k = 0; k < 7; k++) { const to = k > 2 && same < 0 ? -b.poses[c + k] : b.poses[c + k]; p.push(b.poses[a + k] + f * (to - b.poses[a + k])); }
  return p;
}
function coil(a, b, radius, turns) {  // as shapes.py does it
  const way = b.map((x, i) => x - a[i]), n = Math.hypot(...way), z = n > 0 ? way.map(x => x / n) : [0, 0, 1], x = unit(cross(Math.abs(z[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0], z)), y = cross(z, x), found = [a], steps = 12 * turns;
  for (let k = 0; k <= steps; k++) { const s = 0.12 + 0.76 * k / steps, u = 2 * Math.PI * turns * k / steps, c = radius * Math.cos(u), d = radius * Math.sin(u); found.push(a.map((p, i) => p + s * way[i] + c * x[i] + d * y[i])); }
  found.push(b); return found;
}
function tint(light) { const dark = css.bg !== "#fff", base = dark ? 45 : 150, more = dark ? 110 : 105, v = Math.round(base + more * light); return "rgb(" + v + "," + v + "," + v + ")"; }
const SHADES = { white: 1, grey: .8, black: .25 };

function scene() {
  const [g, w, h] = fit($("scene")), A = axes(), k = scale_of(w, h), [i, f] = place(now), j = Math.min(i + 1, N - 1);
  const see = p => { const d = [p[0] - middle[0], p[1] - middle[1], p[2] - middle[2]]; return [w / 2 + eye.x + k * dot(A[0], d), h / 2 + eye.y - k * dot(A[1], d), dot(A[2], d)]; };
  const pen = new Pen(g, w, h, state.names && D.captions.length), items = [], weight = weight_of(D.symbol * k), sun = unit(A[2].map((x, n) => x + .5 * A[1][n] + .35 * A[0][n]));
  for (const b of D.bodies) {
    const p = pose_of(b, i, j, f); if (!p.every(isFinite)) continue;
    const R = turn_of(p.slice(3)), world = [], front = [];
    for (let m = 0; m < b.v.length; m += 3) world.push(R.map((row, n) => p[n] + row[0] * b.v[m] + row[1] * b.v[m + 1] + row[2] * b.v[m + 2]));
    const at = world.map(see);
    b.f.forEach((face, n) => {
      const [o, u, v] = face.slice(0, 3).map(m => world[m]), normal = unit(cross(u.map((x, m) => x - o[m]), v.map((x, m) => x - o[m])));
      front.push(dot(normal, A[2]) > 1e-9);
      if (front[n]) items.push({ depth: face.reduce((s, m) => s + at[m][2], 0) / face.length, points: face.map(m => at[m]), fill: tint(SHADES[b.s] * Math.max(.1, dot(normal, sun))) });
    });
    for (const [a, c, one, other, sharp] of b.e) if (front[one] !== front[other] || (sharp && front[one])) items.push({ depth: (at[a][2] + at[c][2]) / 2 + 1e-3 * D.symbol, points: [at[a], at[c]], line: "thin" });
  }
  for (const l of D.lines) {
    const point = m => { const a = 3 * (i * l.n + m), c = 3 * (j * l.n + m); return [0, 1, 2].map(q => l.points[a + q] + f * (l.points[c + q] - l.points[a + q])); };
    let points = Array.from({ length: l.n }, (_, m) => point(m)); if (!points.every(p => p.every(isFinite))) continue;
    if (l.turns) points = coil(points[0], points[1], l.radius, l.turns);
    const at = points.map(see);
    for (let m = 0; m + 1 < at.length; m += 4) { const part = at.slice(m, m + 5); items.push({ depth: part.reduce((s, p) => s + p[2], 0) / part.length + 1e-3 * D.symbol, points: part, line: l.l }); }
  }
  items.sort((a, b) => a.depth - b.depth); g.lineCap = g.lineJoin = "round";
  for (const item of items) {
    pen.begin(); for (const p of item.points) pen.to(p[0], p[1]);
    if (item.fill) { pen.close(); g.fillStyle = g.strokeStyle = item.fill; g.lineWidth = .6; g.setLineDash([]); g.fill(); g.stroke(); } else { g.strokeStyle = css.fg; g.lineWidth = LW[item.line] * weight; g.setLineDash(item.line === "dashed" ? [5, 4] : []); g.stroke(); }
  }
  g.setLineDash([]);
  if (state.trace) for (const t of D.traces) {
    g.beginPath(); g.strokeStyle = css.hot; g.lineWidth = 1; let on = false;
    for (let m = 0; m <= i; m++) { const p = see([t.at[3 * m], t.at[3 * m + 1], t.at[3 * m + 2]]); if (!p.every(isFinite)) { on = false; continue; } g[on ? "lineTo" : "moveTo"](p[0], p[1]); on = true; }
    g.stroke();
  }
  if (state.names && D.captions.length) captions(pen, D.captions.map(c => { const p = see([c.at[3 * i], c.at[3 * i + 1], c.at[3 * i + 2]]); return p.every(isFinite) ? { words: c.words, x: p[0], y: p[1], u: .7, v: .7 } : null; }), playing);
  corner(g, A, h);
}
function corner(g, A, h) {  // which way the world's axes point
  g.lineWidth = 1; g.font = "11px system-ui, sans-serif"; g.textAlign = "center";
  ["x", "y", "z"].forEach((name, n) => { const x = 34 + 24 * A[0][n], y = h - 34 - 24 * A[1][n]; g.strokeStyle = g.fillStyle = css.soft; g.beginPath(); g.moveTo(34, h - 34); g.lineTo(x, y); g.stroke(); g.fillText(name, 34 + 32 * A[0][n], h - 34 - 32 * A[1][n]); });
}
const look = (azimuth, elevation) => { eye.azimuth = azimuth * Math.PI / 180; eye.elevation = elevation * Math.PI / 180; draw(); };
function watch() {
  const canvas = $("scene"), held = new Map(); let moved = 0;
  const centre = () => { const p = [...held.values()]; return [p.reduce((s, q) => s + q[0], 0) / p.length, p.reduce((s, q) => s + q[1], 0) / p.length, p.length > 1 ? Math.hypot(p[0][0] - p[1][0], p[0][1] - p[1][1]) : 0]; };
  canvas.onpointerdown = e => { canvas.setPointerCapture(e.pointerId); held.set(e.pointerId, [e.clientX, e.clientY]); moved = held.size > 1 ? 9 : 0; };
  canvas.onpointermove = e => {
    if (!held.has(e.pointerId)) return;
    const before = centre(); held.set(e.pointerId, [e.clientX, e.clientY]); const after = centre(), x = after[0] - before[0], y = after[1] - before[1]; moved += Math.abs(x) + Math.abs(y);
    if (held.size > 1 || e.shiftKey || e.buttons & 2) { eye.x += x; eye.y += y; if (before[2] > 0 && after[2] > 0) zoom(after[2] / before[2], after[0], after[1]); }
    else { eye.azimuth -= x * .008; eye.elevation = Math.max(-Math.PI / 2, Math.min(Math.PI / 2, eye.elevation + y * .008)); }
    draw();
  };
  canvas.onpointerup = canvas.onpointercancel = e => { held.delete(e.pointerId); };
  canvas.onclick = () => { if (moved < 4) play(); };
  canvas.ondblclick = () => { eye = { ...START }; draw(); };
  canvas.oncontextmenu = e => e.preventDefault();
  canvas.onwheel = e => { e.preventDefault(); zoom(Math.exp(-e.deltaY * .0015), e.clientX, e.clientY); draw(); };
  for (const button of document.querySelectorAll("[data-view]")) button.onclick = () => look(...button.dataset.view.split(" ").map(Number));
  addEventListener("keydown", e => { const n = ["0", "1", "2", "3"].indexOf(e.key); if (n >= 0 && !e.ctrlKey && !e.metaKey && !e.altKey) document.querySelectorAll("[data-view]")[n].click(); });
}
function zoom(by, x, y) {  // about a place of the window
  const box = $("scene").getBoundingClientRect(), u = x - box.left - box.width / 2, v = y - box.top - box.height / 2;
  const to = Math.max(.05, Math.min(200, eye.zoom * by)), real = to / eye.zoom; eye.x = u - (u - eye.x) * real; eye.y = v - (v - eye.y) * real; eye.zoom = to;
}
begin();
window.lagrangia.look = look; Object.defineProperty(window.lagrangia, "eye", { get: () => ({ ...eye }) });
