// What pages that play and pages that compute have in common.
const $ = id => document.getElementById(id);
let css = {};
function bytes(text) { const b = atob(text), a = new Uint8Array(b.length); for (let i = 0; i < b.length; i++) a[i] = b.charCodeAt(i); return a.buffer; }
const LW = { normal: 1.6, round: 1.6, thin: 1, dashed: 1, thick: 2.8 };

function colours() { const s = getComputedStyle(document.documentElement); for (const k of ["fg", "bg", "soft", "grey", "line", "hot"]) css[k] = s.getPropertyValue("--" + k).trim(); }
function fit(canvas) {
  const r = devicePixelRatio || 1, w = canvas.clientWidth, h = canvas.clientHeight;
  if (canvas.width !== Math.round(w * r) || canvas.height !== Math.round(h * r)) { canvas.width = Math.round(w * r); canvas.height = Math.round(h * r); }
  const g = canvas.getContext("2d"); g.setTransform(r, 0, 0, r, 0, 0); g.clearRect(0, 0, w, h); return [g, w, h];
}
function ink(g, line, fill, is_closed, weight) {
  const fills = { none: "", white: css.bg, grey: css.grey, black: css.fg };
  if (is_closed) g.closePath();
  if (fills[fill]) { g.fillStyle = fills[fill]; g.fill(); }
  g.strokeStyle = css.fg; g.lineWidth = LW[line] * weight; g.setLineDash(line === "dashed" ? [5, 4] : []); g.stroke();
}
const font = p => (p[1] ? "italic " : "") + (p[2] ? 11 : 15) + "px 'STIX Two Text','Times New Roman',serif";
const width_of = (g, pieces) => pieces.reduce((w, p) => { g.font = font(p); return w + g.measureText(p[0]).width; }, 0);
function words(g, pieces, x, y) {  // from x on, about y
  g.strokeStyle = css.bg; g.lineWidth = 3; g.lineJoin = "round";  // lines do not run through words
  let from = x; for (const p of pieces) { g.font = font(p); g.strokeText(p[0], from, y + 5 + (p[2] ? 4 : 0)); from += g.measureText(p[0]).width; }
  for (const p of pieces) { g.font = font(p); g.fillText(p[0], x, y + 5 + (p[2] ? 4 : 0)); x += g.measureText(p[0]).width; }
}
// Captions { words, x, y, u, v }: beside their places towards (u, v), or about them, else where it is free; where nothing is, they wait.
const WAYS = [0, 1, -1, 2, -2, 3, -3, 4].map(k => [Math.cos(k * Math.PI / 4), Math.sin(k * Math.PI / 4)]), chosen = [];
function captions(g, all) {
  const taken = [], free = b => taken.every(o => b[0] > o[2] || b[2] < o[0] || b[1] > o[3] || b[3] < o[1]);
  g.fillStyle = css.fg;
  all.forEach((c, i) => {
    if (!c) return;
    const w = width_of(g, c.words), [a, b] = c.u || c.v ? [c.u, c.v] : [0, 1], places = c.u || c.v ? [] : [[0, 0]];
    for (const reach of [0, 14]) for (const [p, q] of WAYS) { const u = a * p - b * q, v = a * q + b * p; places.push([u * (8 + w / 2 + reach), -v * (13 + reach)]); }
    const box = k => { const x = Math.max(2, Math.min(c.x + places[k][0] - w / 2, g.canvas.clientWidth - w - 2)), y = c.y + places[k][1]; return [x, y - 8, x + w, y + 9]; };
    const order = [...places.keys()], k = (chosen[i] < places.length ? [chosen[i], ...order] : order).find(k => free(box(k)));
    chosen[i] = k;
    if (k === undefined) return;
    taken.push(box(k)); words(g, c.words, box(k)[0], box(k)[1] + 8);
  });
}
const weight_of = symbol => Math.max(0.2, Math.min(1, symbol / 7));  // of lines, where symbols are so small, in pixels
const TINTS = ["#1f77b4", "#d62728", "#2ca02c", "#9467bd", "#ff7f0e", "#17becf", "#8c564b", "#e377c2"];
function graphs(canvas, all, T, N, from, to, now, events) {  // returns where time runs from left to right, of each graph
  const [g, w, h] = fit(canvas), plots = []; g.font = "12px system-ui, sans-serif"; g.textBaseline = "middle";
  const units = [...new Set(all.map(c => c.unit))], L = 56, R = 8, gap = 22, each = (h - 20) / Math.max(1, units.length);
  units.forEach((unit, row) => {
    const mine = all.filter(c => c.unit === unit), top = row * each + gap, bottom = (row + 1) * each - 4;
    let lo = Infinity, hi = -Infinity;
    for (const c of mine) for (let m = 0; m < N; m++) { const y = c.y[m]; if (isFinite(y)) { if (y < lo) lo = y; if (y > hi) hi = y; } }
    if (!(lo <= hi)) { lo = 0; hi = 1; } if (hi - lo < 1e-12 * Math.max(Math.abs(lo), Math.abs(hi), 1e-300)) { lo -= 1; hi += 1; }
    const X = t => L + (w - L - R) * (t - from) / (to - from || 1), Y = y => bottom - (bottom - top) * (y - lo) / (hi - lo);
    g.strokeStyle = css.line; g.lineWidth = 1; g.strokeRect(L, top, w - L - R, bottom - top);
    g.beginPath(); for (const t of events) if (t >= from && t <= to) { g.moveTo(X(t), bottom); g.lineTo(X(t), bottom - 6); } g.strokeStyle = css.soft; g.stroke(); g.strokeStyle = css.line;
    if (lo < 0 && hi > 0) { g.beginPath(); g.moveTo(L, Y(0)); g.lineTo(w - R, Y(0)); g.stroke(); }
    g.fillStyle = css.soft; g.textAlign = "right"; g.fillText(short(hi, hi - lo), L - 4, top + 6); g.fillText(short(lo, hi - lo), L - 4, bottom - 6); g.fillText(unit, L - 4, (top + bottom) / 2);
    let at = L; g.textAlign = "left";
    mine.forEach((c, k) => {
      g.strokeStyle = g.fillStyle = TINTS[k % TINTS.length]; g.lineWidth = 1.4; g.beginPath(); let on = false;
      for (let m = 0; m < N; m++) { if (!isFinite(c.y[m])) { on = false; continue; } g[on ? "lineTo" : "moveTo"](X(T[m]), Y(c.y[m])); on = true; }
      g.stroke(); const room = g.measureText(c.name).width; if (at + room < w) g.fillText(c.name, at, top - 9); at += room + 14;
      if (isFinite(c.now)) { g.beginPath(); g.arc(X(now), Y(c.now), 3.5, 0, 7); g.fill(); }
    });
    g.strokeStyle = css.hot; g.lineWidth = 1; g.beginPath(); g.moveTo(X(now), top); g.lineTo(X(now), bottom); g.stroke();
    plots.push([L, w - R]);
  });
  g.fillStyle = css.soft; g.textAlign = "left"; g.fillText(short(from) + " s", L, h - 9); g.textAlign = "right"; g.fillText(short(to) + " s", w - R, h - 9);
  return plots;
}
function bars(canvas, energies, greatest) {
  const [g, w] = fit(canvas); g.font = "12px system-ui, sans-serif"; g.textBaseline = "middle";
  if (!energies.length) return;
  let at = 56; const most = greatest || 1, room = w - 64, value = e => isFinite(e.value) ? e.value : 0;
  energies.forEach((e, k) => { const v = Math.max(0, value(e) - e.least), x = room * v / most; g.fillStyle = TINTS[k]; g.globalAlpha = .8; g.fillRect(at, 8, x, 16); g.globalAlpha = 1; at += x; });
  g.fillStyle = css.soft; g.textAlign = "right"; g.fillText("J", 50, 16); let x = 56; g.textAlign = "left";
  energies.forEach((e, k) => { g.fillStyle = TINTS[k]; const s = e.name + " " + short(value(e)); g.fillText(s, x, 38); x += Math.max(g.measureText(s).width + 10, room / 3.2); });
}
function short(x, range = 0) { if (Math.abs(x) < 1e-9 * range) return "0"; const a = Math.abs(x); return x === 0 ? "0" : a >= 1e4 || a < 1e-3 ? x.toExponential(1) : String(+x.toPrecision(3)); }
const clock = (t, length) => (length < 0.1 ? t.toExponential(3) : t.toFixed(3)) + " s";
function other_theme() { const r = document.documentElement, dark = css.bg !== "#fff"; r.removeAttribute("data-dark"); r.removeAttribute("data-light"); r.setAttribute(dark ? "data-light" : "data-dark", ""); colours(); }
const SPEEDS = [1e-6, 1e-5, 1e-4, 0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.25, 0.5, 1, 2, 4, 10, 30, 100, 1000, 1e4, 1e5];
const beside = (speed, by) => SPEEDS[Math.max(0, Math.min(SPEEDS.length - 1, SPEEDS.indexOf(speed) + by))];
function faster(wanted) {  // the speed nearest to what is wanted becomes the chosen one
  if (!$("speed").options.length) for (const s of SPEEDS) $("speed").add(new Option(s + " ×", s));
  const speed = SPEEDS.reduce((a, b) => Math.abs(Math.log(b / wanted)) < Math.abs(Math.log(a / wanted)) ? b : a);
  $("speed").value = speed; return speed;
}
