// Curves over time, a graph for each unit with its legend above it: all names, by wrapping, then by scrolling.
const TINTS = ["#1f77b4", "#d62728", "#2ca02c", "#9467bd", "#ff7f0e", "#17becf", "#8c564b", "#e377c2"];
const DASHES = [[], [7, 4], [2, 3]], KINDS = ["solid", "dashed", "dotted"];  // of those that take a colour again
const LEFT = 56, RIGHT = 8;
const look_of = k => { const i = Math.floor(k / TINTS.length) % DASHES.length; return { tint: TINTS[k % TINTS.length], dashes: DASHES[i], kind: KINDS[i] }; };
const made = (kind, parent, text = "") => { const e = document.createElement(kind); e.textContent = text; parent.append(e); return e; };
function graph_of(box, unit, mine) {
  const figure = made("figure", box), legend = made("figcaption", figure), canvas = made("canvas", figure);
  mine.forEach((c, k) => {
    const look = look_of(k), entry = made("span", legend);
    entry.style.color = look.tint; made("i", entry).style.borderTop = "2px " + look.kind; entry.append(c.name);
  });
  canvas.setAttribute("role", "img"); canvas.setAttribute("aria-label", "curves over time" + (unit && ", " + unit));
  return canvas;
}
function graphs(box, all, T, N, from, to, now, events) {
  const units = [...new Set(all.map(c => c.unit))];
  if (!box.canvases) { box.canvases = units.map(unit => graph_of(box, unit, all.filter(c => c.unit === unit))); const span = made("p", box); box.ends = [made("span", span), made("span", span)]; }
  units.forEach((unit, row) => graph(box.canvases[row], unit, all.filter(c => c.unit === unit), T, N, from, to, now, events));
  box.ends[0].textContent = short(from) + " s"; box.ends[1].textContent = short(to) + " s";
}
function graph(canvas, unit, mine, T, N, from, to, now, events) {
  const [g, w, h] = fit(canvas), top = 4, bottom = h - 5;
  g.font = "12px system-ui, sans-serif"; g.textBaseline = "middle";
  let lo = Infinity, hi = -Infinity;
  for (const c of mine) for (let m = 0; m < N; m++) { const y = c.y[m]; if (isFinite(y)) { if (y < lo) lo = y; if (y > hi) hi = y; } }
  if (!(lo <= hi)) { lo = 0; hi = 1; } if (hi - lo < 1e-12 * Math.max(Math.abs(lo), Math.abs(hi), 1e-300)) { lo -= 1; hi += 1; }
  const X = t => LEFT + (w - LEFT - RIGHT) * (t - from) / (to - from || 1), Y = y => bottom - (bottom - top) * (y - lo) / (hi - lo);
  g.strokeStyle = css.line; g.lineWidth = 1; g.strokeRect(LEFT, top, w - LEFT - RIGHT, bottom - top);
  g.beginPath(); for (const t of events) if (t >= from && t <= to) { g.moveTo(X(t), bottom); g.lineTo(X(t), bottom - 6); } g.strokeStyle = css.soft; g.stroke(); g.strokeStyle = css.line;
  if (lo < 0 && hi > 0) { g.beginPath(); g.moveTo(LEFT, Y(0)); g.lineTo(w - RIGHT, Y(0)); g.stroke(); }
  g.fillStyle = css.soft; g.textAlign = "right"; [[short(hi, hi - lo), top + 6], [short(lo, hi - lo), bottom - 6], [unit, (top + bottom) / 2]].forEach(([text, y]) => g.fillText(text, LEFT - 4, y, LEFT - 6));
  mine.forEach((c, k) => {
    const look = look_of(k);
    g.strokeStyle = g.fillStyle = look.tint; g.lineWidth = 1.4; g.setLineDash(look.dashes); g.beginPath(); let on = false;
    for (let m = 0; m < N; m++) { if (!isFinite(c.y[m])) { on = false; continue; } g[on ? "lineTo" : "moveTo"](X(T[m]), Y(c.y[m])); on = true; }
    g.stroke(); g.setLineDash([]);
    if (isFinite(c.now)) { g.beginPath(); g.arc(X(now), Y(c.now), 3.5, 0, 7); g.fill(); }
  });
  g.strokeStyle = css.hot; g.lineWidth = 1; g.beginPath(); g.moveTo(X(now), top); g.lineTo(X(now), bottom); g.stroke();
}
function bars(canvas, energies, greatest) {
  const [g, w] = fit(canvas); g.font = "12px system-ui, sans-serif"; g.textBaseline = "middle";
  if (!energies.length) return;
  let at = 56; const most = greatest || 1, room = w - 64, value = e => isFinite(e.value) ? e.value : 0;
  energies.forEach((e, k) => { const v = Math.max(0, value(e) - e.least), x = room * v / most; g.fillStyle = TINTS[k]; g.globalAlpha = .8; g.fillRect(at, 8, x, 16); g.globalAlpha = 1; at += x; });
  g.fillStyle = css.soft; g.textAlign = "right"; g.fillText("J", 50, 16); g.textAlign = "left";
  const told = energies.map(e => e.name + " " + short(value(e), most)), widths = told.map(s => g.measureText(s).width);
  const even = room / energies.length, whole = widths.reduce((a, b) => a + b + 8, 0), narrow = Math.min(1, room / whole);
  for (let k = 0, x = LEFT, is_even = widths.every(s => s + 8 <= even); k < told.length; k++) { g.fillStyle = TINTS[k]; g.fillText(told[k], x, 38, narrow * widths[k]); x += is_even ? even : narrow * (widths[k] + 8) + Math.max(0, room - whole) / told.length; }
}
