// A scene of the plane, as it is now.
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
const seen = place_of, per_metre = () => view.k;
const pointer = e => { const box = $("scene").getBoundingClientRect(); return [view.x(e.clientX - box.left), view.y(e.clientY - box.top)]; };
function watch() {
  const canvas = $("scene");
  canvas.onpointerdown = e => grab(e, 40); canvas.onpointermove = drag; canvas.onpointerup = canvas.onpointercancel = () => { held = null; };
}
