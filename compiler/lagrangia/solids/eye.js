// From where a scene in space is seen: far away; turned, shifted and zoomed by hand. Solids and lines, from behind to in front.
const UP = unit(D.up), EAST = (() => { const k = UP.map(Math.abs).indexOf(Math.min(...UP.map(Math.abs))), e = [0, 0, 0]; e[k] = 1; const a = dot(e, UP); return unit(e.map((x, i) => x - a * UP[i])); })(), NORTH = cross(UP, EAST);
const middle = D.low.map((x, i) => (x + D.high[i]) / 2), reach = Math.hypot(...D.low.map((x, i) => D.high[i] - x)) || 1;
const START = { azimuth: -60 * Math.PI / 180, elevation: 22 * Math.PI / 180, zoom: 1, x: 0, y: 0 };
let eye = { ...START }, hand = null;  // of a page whose parts can be taken: take, move, leave

function axes() {  // to the right, upwards, towards the eye
  const c = Math.cos(eye.azimuth), s = Math.sin(eye.azimuth), e = Math.cos(eye.elevation), z = Math.sin(eye.elevation);
  const level = EAST.map((x, i) => c * x + s * NORTH[i]), forth = level.map((x, i) => e * x + z * UP[i]), right = cross(UP, level);
  return [right, cross(forth, right), forth];
}
const scale_of = (w, h) => eye.zoom * Math.min(w, h) / reach;
function tint(light) { const dark = css.bg !== "#fff", base = dark ? 45 : 150, more = dark ? 110 : 105, v = Math.round(base + more * light); return "rgb(" + v + "," + v + "," + v + ")"; }
const SHADES = { white: 1, grey: .8, black: .25 };

// bodies: { v: [x, y, z, ...] in their axes, at: place, turn: matrix of these axes, f: faces, e: edges, s: shade }; lines: { l: line, points };
// names: [{ words, at } or null]; traces: [[x, y, z, x, y, z, ...]].
function render(bodies, lines, names, traces, is_moving) {
  const [g, w, h] = fit($("scene")), A = axes(), k = scale_of(w, h);
  const see = p => { const d = [p[0] - middle[0], p[1] - middle[1], p[2] - middle[2]]; return [w / 2 + eye.x + k * dot(A[0], d), h / 2 + eye.y - k * dot(A[1], d), dot(A[2], d)]; };
  const pen = new Pen(g, w, h, state.names && names.length), items = [], weight = weight_of(D.symbol * k), sun = unit(A[2].map((x, n) => x + .5 * A[1][n] + .35 * A[0][n]));
  for (const b of bodies) {
    const world = [], front = [];
    for (let m = 0; m < b.v.length; m += 3) world.push(b.turn.map((row, n) => b.at[n] + row[0] * b.v[m] + row[1] * b.v[m + 1] + row[2] * b.v[m + 2]));
    const at = world.map(see);
    b.f.forEach((face, n) => {
      const [o, u, v] = face.slice(0, 3).map(m => world[m]), normal = unit(cross(u.map((x, m) => x - o[m]), v.map((x, m) => x - o[m])));
      front.push(dot(normal, A[2]) > 1e-9);
      if (front[n]) items.push({ depth: face.reduce((s, m) => s + at[m][2], 0) / face.length, points: face.map(m => at[m]), fill: tint(SHADES[b.s] * Math.max(.1, dot(normal, sun))) });
    });
    for (const [a, c, one, other, sharp] of b.e) if (front[one] !== front[other] || (sharp && front[one])) items.push({ depth: (at[a][2] + at[c][2]) / 2 + 1e-3 * D.symbol, points: [at[a], at[c]], line: "thin" });
  }
  for (const { l, points } of lines) {
    const at = points.map(see);
    for (let m = 0; m + 1 < at.length; m += 4) { const part = at.slice(m, m + 5); items.push({ depth: part.reduce((s, p) => s + p[2], 0) / part.length + 1e-3 * D.symbol, points: part, line: l }); }
  }
  items.sort((a, b) => a.depth - b.depth); g.lineCap = g.lineJoin = "round";
  for (const item of items) {
    pen.begin(); for (const p of item.points) pen.to(p[0], p[1]);
    if (item.fill) { pen.close(); g.fillStyle = g.strokeStyle = item.fill; g.lineWidth = .6; g.setLineDash([]); g.fill(); g.stroke(); } else { g.strokeStyle = css.fg; g.lineWidth = LW[item.line] * weight; g.setLineDash(item.line === "dashed" ? [5, 4] : []); g.stroke(); }
  }
  g.setLineDash([]);
  if (state.trace) for (const t of traces) {
    g.beginPath(); g.strokeStyle = css.hot; g.lineWidth = 1; let on = false;
    for (let m = 0; m < t.length; m += 3) { const p = see([t[m], t[m + 1], t[m + 2]]); if (!p.every(isFinite)) { on = false; continue; } g[on ? "lineTo" : "moveTo"](p[0], p[1]); on = true; }
    g.stroke();
  }
  if (state.names && names.length) captions(pen, names.map(c => { const p = c && see(c.at); return p && p.every(isFinite) ? { words: c.words, x: p[0], y: p[1], u: .7, v: .7 } : null; }), is_moving);
  corner(g, A, h);
}
function corner(g, A, h) {  // which way the world's axes point
  g.lineWidth = 1; g.font = "11px system-ui, sans-serif"; g.textAlign = "center";
  ["x", "y", "z"].forEach((name, n) => { const x = 34 + 24 * A[0][n], y = h - 34 - 24 * A[1][n]; g.strokeStyle = g.fillStyle = css.soft; g.beginPath(); g.moveTo(34, h - 34); g.lineTo(x, y); g.stroke(); g.fillText(name, 34 + 32 * A[0][n], h - 34 - 32 * A[1][n]); });
}
const turn_to = (azimuth, elevation) => { eye.azimuth = azimuth * Math.PI / 180; eye.elevation = elevation * Math.PI / 180; draw(); };
function watch() {
  const canvas = $("scene"), fingers = new Map(); let moved = 0;
  const centre = () => { const p = [...fingers.values()]; return [p.reduce((s, q) => s + q[0], 0) / p.length, p.reduce((s, q) => s + q[1], 0) / p.length, p.length > 1 ? Math.hypot(p[0][0] - p[1][0], p[0][1] - p[1][1]) : 0]; };
  canvas.onpointerdown = e => { 
    if (hand && fingers.size === 0 && hand.take(e)) { moved = 0; return; }
    canvas.setPointerCapture(e.pointerId); fingers.set(e.pointerId, [e.clientX, e.clientY]); moved = fingers.size > 1 ? 9 : 0;
  };
  canvas.onpointermove = e => {
    if (hand && fingers.size === 0 && hand.move(e)) { moved += 4; return; }
    if (!fingers.has(e.pointerId)) return;
    const before = centre(); fingers.set(e.pointerId, [e.clientX, e.clientY]); const after = centre(), x = after[0] - before[0], y = after[1] - before[1]; moved += Math.abs(x) + Math.abs(y);
    if (fingers.size > 1 || e.shiftKey || e.buttons & 2) { eye.x += x; eye.y += y; if (before[2] > 0 && after[2] > 0) zoom(after[2] / before[2], after[0], after[1]); }
    else { eye.azimuth -= x * .008; eye.elevation = Math.max(-Math.PI / 2, Math.min(Math.PI / 2, eye.elevation + y * .008)); }
    draw();
  };
  canvas.onpointerup = canvas.onpointercancel = e => { fingers.delete(e.pointerId); if (hand) hand.leave(); };
  canvas.onclick = () => { if (moved < 4) play(); };
  canvas.ondblclick = () => { eye = { ...START }; draw(); };
  canvas.oncontextmenu = e => e.preventDefault();
  canvas.onwheel = e => { e.preventDefault(); zoom(Math.exp(-e.deltaY * .0015), e.clientX, e.clientY); draw(); };
  for (const button of document.querySelectorAll("[data-view]")) button.onclick = () => turn_to(...button.dataset.view.split(" ").map(Number));
  addEventListener("keydown", e => { if (e.target.type === "number" || e.target.tagName === "SELECT") return; const n = ["0", "1", "2", "3"].indexOf(e.key); if (n >= 0 && !e.ctrlKey && !e.metaKey && !e.altKey) document.querySelectorAll("[data-view]")[n].click(); });
}
function zoom(by, x, y) {  // about a place of the window
  const box = $("scene").getBoundingClientRect(), u = x - box.left - box.width / 2, v = y - box.top - box.height / 2;
  const to = Math.max(.05, Math.min(200, eye.zoom * by)), real = to / eye.zoom; eye.x = u - (u - eye.x) * real; eye.y = v - (v - eye.y) * real; eye.zoom = to;
}
window.lagrangia.look = turn_to; Object.defineProperty(window.lagrangia, "eye", { get: () => ({ ...eye }) });
