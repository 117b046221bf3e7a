// A scene of the plane: strokes that stand, ride on a frame, or change their shape.
const U = text => new Uint16Array(bytes(text)), GONE = 65535;
const x0 = D.low[0], y0 = D.low[1], Q = D.span / 65534;
for (const s of D.strokes) { if (s.points) s.data = U(s.points); if (s.poses) s.data = F(s.poses); }
for (const c of D.captions) { c.at = U(c.at); c.side = F(c.side); }
for (const t of D.traces) t.at = U(t.at);
const watch = () => { $("scene").onclick = play; };
function scene() {
  const [g, w, h] = fit($("scene"));
  const W = D.high[0] - x0, H = D.high[1] - y0, k = Math.min((w - 16) / W, (h - 16) / H, 42 / D.symbol);
  const X = x => w / 2 + (x - x0 - W / 2) * k, Y = y => h / 2 - (y - y0 - H / 2) * k;
  const [i, f] = place(now), j = Math.min(i + 1, N - 1);
  const pen = new Pen(g, w, h, state.names && D.captions.length);
  g.lineCap = g.lineJoin = "round"; const weight = weight_of(D.symbol * k);
  if (state.trace) for (const t of D.traces) {
    g.beginPath(); g.strokeStyle = css.hot; g.lineWidth = 1; let on = false;
    for (let m = 0; m <= i; m++) { const a = t.at[2 * m], b = t.at[2 * m + 1]; if (a === GONE) { on = false; continue; } g[on ? "lineTo" : "moveTo"](X(x0 + a * Q), Y(y0 + b * Q)); on = true; }
    g.stroke();
  }
  for (const s of D.strokes) {
    pen.begin(); const n = s.n; let seen = true;
    let c = 1, d = 0, px = 0, py = 0;
    if (s.poses) { const p = s.data, a = 3 * i, b = 3 * j; px = p[a] + f * (p[b] - p[a]); py = p[a + 1] + f * (p[b + 1] - p[a + 1]); const q = p[a + 2] + f * (p[b + 2] - p[a + 2]); c = Math.cos(q); d = Math.sin(q); }
    for (let m = 0; m < n && seen; m++) {
      let x, y;
      if (s.points) {
        const a = 2 * (i * n + m), b = 2 * (j * n + m); let u = s.data[a], v = s.data[a + 1];
        if (u === GONE) { seen = false; break; }
        if (s.data[b] !== GONE) { u += f * (s.data[b] - u); v += f * (s.data[b + 1] - v); }
        x = x0 + u * Q; y = y0 + v * Q;
      } else { const u = s.p[2 * m], v = s.p[2 * m + 1]; x = px + c * u - d * v; y = py + d * u + c * v; }
      if (s.r > 0) pen.round(X(x), Y(y), Math.max(s.r * k, 1)); else pen.to(X(x), Y(y));
    }
    if (!seen) continue;
    ink(pen, s.l, s.f, s.c && !s.r, weight);
  }
  g.setLineDash([]);
  if (state.names) captions(pen, D.captions.map(l => l.at[2 * i] === GONE ? null : { words: l.words, x: X(x0 + l.at[2 * i] * Q), y: Y(y0 + l.at[2 * i + 1] * Q), u: l.side[2 * i], v: l.side[2 * i + 1] }), playing);
}
begin();
