const D = JSON.parse(document.getElementById("data").textContent);
const U = text => new Uint16Array(bytes(text)), F = text => new Float32Array(bytes(text));
const T = new Float64Array(bytes(D.t)), N = T.length, GONE = 65535;
for (const s of D.strokes) { if (s.points) s.data = U(s.points); if (s.poses) s.data = F(s.poses); }
for (const c of D.captions) { c.at = U(c.at); c.side = F(c.side); }
for (const t of D.traces) t.at = U(t.at);
for (const c of [...D.curves, ...D.energies]) { const y = F(c.y); c.y = c.base ? Float64Array.from(y, x => c.base + x) : y; }
if (!D.curves.length && !D.energies.length) document.querySelector("aside").style.display = "none";
const span = D.span, x0 = D.low[0], y0 = D.low[1], Q = span / 65534;
let now = T[0], playing = false, last = 0, speed = 1;
const state = { loop: true, trace: true, names: true };

function place(t) {  // the row before t, and how far on it is
  let a = 0, b = N - 1; if (N < 2 || t <= T[0]) return [0, 0]; if (t >= T[b]) return [b, 0];
  while (b - a > 1) { const m = (a + b) >> 1; if (T[m] <= t) a = m; else b = m; }
  return [a, (t - T[a]) / (T[b] - T[a] || 1)];
}
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
const between = y => { const [i, f] = place(now); return y[i] + f * (y[Math.min(i + 1, N - 1)] - y[i]); };
function draw() { scene(); graphs($("curves"), D.curves.map(c => ({ name: c.name, unit: c.unit, y: c.y, now: between(c.y) })), T, N, T[0], T[N - 1], now, D.events);
  bars($("energy"), D.energies.map(e => ({ name: e.name, least: e.least, value: between(e.y) })), D.most); $("time").value = now; $("now").textContent = "t = " + clock(now, T[N - 1] - T[0]); $("play").innerHTML = playing ? "&#10074;&#10074;" : "&#9654;"; }
function tick(ms) {
  if (!playing) return;
  now += (ms - last) / 1000 * speed; last = ms;
  if (now >= T[N - 1]) { if (state.loop && T[N - 1] > T[0]) now = T[0] + (now - T[0]) % (T[N - 1] - T[0]); else { now = T[N - 1]; playing = false; } }
  draw(); requestAnimationFrame(tick);
}
function play() { playing = !playing; if (playing) { if (now >= T[N - 1]) now = T[0]; last = performance.now(); requestAnimationFrame(tick); } draw(); }
function step(by) { playing = false; let [i, f] = place(now); if (f > 1 - 1e-6) { i++; f = 0; } now = T[Math.max(0, Math.min(N - 1, by < 0 && f > 1e-9 ? i : i + by))]; draw(); }
function toggle(id) { state[id] = !state[id]; $(id).setAttribute("aria-pressed", state[id]); draw(); }
const fast = s => { speed = faster(s); };
$("time").min = T[0]; $("time").max = T[N - 1];
$("time").oninput = e => { playing = false; now = +e.target.value; draw(); };
$("play").onclick = play; $("back").onclick = () => step(-1); $("ahead").onclick = () => step(1);
$("speed").onchange = e => { speed = +e.target.value; };
for (const id of ["loop", "trace", "names"]) $(id).onclick = () => toggle(id);
const theme = () => { other_theme(); draw(); }; $("theme").onclick = theme; $("scene").onclick = play;
const seek = e => { const box = e.target.getBoundingClientRect(); playing = false; now = T[0] + Math.max(0, Math.min(1, (e.clientX - box.left - LEFT) / (box.width - LEFT - RIGHT))) * (T[N - 1] - T[0]); draw(); };
document.onkeydown = e => {
  if (e.ctrlKey || e.metaKey || e.altKey || e.target.tagName === "SELECT") return;
  const k = e.key;
  const does = { " ": play, ArrowLeft: () => step(-1), ArrowRight: () => step(1), Home: () => { now = T[0]; draw(); }, End: () => { playing = false; now = T[N - 1]; draw(); },
    l: () => toggle("loop"), t: () => toggle("trace"), n: () => toggle("names"), d: theme, "+": () => fast(beside(speed, 1)), "-": () => fast(beside(speed, -1)) }[k];
  if (does) { e.preventDefault(); does(); }
};
addEventListener("resize", draw); matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { colours(); draw(); });
if (!D.traces.length) $("trace").hidden = true; if (!D.captions.length) $("names").hidden = true;
fast(D.speed); colours(); draw();
for (const c of $("curves").canvases) { c.onpointerdown = e => { c.setPointerCapture(e.pointerId); seek(e); }; c.onpointermove = e => { if (e.buttons) seek(e); }; }
window.lagrangia = { get time() { return now; }, go(t) { playing = false; now = t; draw(); }, get playing() { return playing; }, value(name) { return between(D.curves.find(c => c.name === name).y); } };
