// A scene of the plane, as it is now, and parts that are dragged to where it starts.
let view = null;
const place_of = ([k, x, y], drawn) => [drawn[k] + x, drawn[k + 1] + y], point_of = trace => place_of(trace.slice(1), rows), WIDTH = 2;
function scene() {
  const [g, w, h] = fit($("scene")), { strokes, named } = picture(D, rows);
  for (const s of strokes) if (s.layer !== ARROWS && s.layer !== RAILS) for (let i = 0; i < s.p.length; i++) { const k = i % 2; low[k] = Math.min(low[k], s.p[i] - s.r); high[k] = Math.max(high[k], s.p[i] + s.r); }
  const W = high[0] - low[0], H = high[1] - low[1], k = Math.min((w - 16) / W, (h - 16) / H, 42 / S);
  const X = x => w / 2 + (x - low[0] - W / 2) * k, Y = y => h / 2 - (y - low[1] - H / 2) * k;
  view = { x: u => low[0] + W / 2 + (u - w / 2) / k, y: v => low[1] + H / 2 - (v - h / 2) / k, k };
  const pen = new Pen(g, w, h, state.names && named.length);
  g.lineCap = g.lineJoin = "round"; const weight = weight_of(S * k);
  if (state.trace) for (const t of traces) { g.beginPath(); g.strokeStyle = css.hot; g.lineWidth = 1; for (let i = 0; i < t.length; i += 2) g[i ? "lineTo" : "moveTo"](X(t[i]), Y(t[i + 1])); g.stroke(); }
  for (const s of strokes) {
    pen.begin();
    if (s.r > 0) pen.round(X(s.p[0]), Y(s.p[1]), Math.max(s.r * k, 1));
    else for (let i = 0; i < s.p.length; i += 2) pen.to(X(s.p[i]), Y(s.p[i + 1]));
    ink(pen, s.l, s.f, s.c && !s.r, weight);
  }
  g.setLineDash([]);
  if (state.names) captions(pen, named.map(found => { if (!found) return null; const [words, x, y, u, v] = found; return { words, x: X(x), y: Y(y), u, v }; }), running);
}
// The start at which a frame is nearest to the pointer
let held = null;
const pointer = e => { const box = $("scene").getBoundingClientRect(); return [view.x(e.clientX - box.left), view.y(e.clientY - box.top)]; };
function grab(e) {
  const [x, y] = pointer(e), far = D.frames.map(f => { const [u, v] = place_of(f, rows); return hypot(u - x, v - y); }), best = far.indexOf(Math.min(...far));
  if (!D.movable.length || best < 0 || far[best] * view.k > 40) return;
  held = D.frames[best]; running = false; $("scene").setPointerCapture(e.pointerId);
}
function posed(values) {  // the numbers of the drawing there; in a loop the other coordinates follow as they do at a start
  if (!D.is_looped) { const q = now.slice(1, 1 + D.n); D.movable.forEach(({ k }, i) => { q[k] = values[i]; }); return machine.drawing(q); }
  const asked = new Map(given);
  D.movable.forEach(({ k }, i) => asked.set(1 + k, values[i]));
  return machine.begin(asked, D.tolerance, D.stop) ? machine.drawing() : null;
}
function drag(e) {
  if (!held || !now) return;
  const target = pointer(e), parts = D.movable, tiny = D.is_looped ? 1e-5 : 1e-6;
  let values = parts.map(({ k }) => now[1 + k]), best = null;
  for (let round = 0; round < (D.is_looped ? 3 : 8); round++) {  // least squares with little damping: one point, many coordinates
    const at = posed(values);
    if (!at) break;
    best = values;
    const [x, y] = place_of(held, at), gap = [target[0] - x, target[1] - y], J = [];
    for (let i = 0; i < parts.length; i++) {
      const h = tiny * parts[i].size, other = posed(values.map((v, j) => j === i ? v + h : v)), [u, v] = other ? place_of(held, other) : [x, y];
      J.push([(u - x) / tiny, (v - y) / tiny]);
    }
    let a = 1e-6 * S * S, b = 0, d = a;
    for (const [u, v] of J) { a += u * u; b += u * v; d += v * v; }
    const det = a * d - b * b, u = (d * gap[0] - b * gap[1]) / det, v = (a * gap[1] - b * gap[0]) / det;
    values = values.map((q, i) => q + parts[i].size * clip(J[i][0] * u + J[i][1] * v, -0.3, 0.3));
  }
  if (posed(values)) best = values;
  const before = new Map(given);
  if (best) parts.forEach(({ k }, i) => given.set(1 + k, best[i]));
  if (!restart()) { const why = machine.message; given.clear(); for (const [ref, value] of before) given.set(ref, value); restart(); tell(why); }
  for (const c of D.controls) if (c.kind === "start" && given.has(c.ref)) { c.now = given.get(c.ref); show(c); }
  draw();
}
function watch() {
  const canvas = $("scene");
  canvas.onpointerdown = grab; canvas.onpointermove = drag; canvas.onpointerup = canvas.onpointercancel = () => { held = null; };
}
