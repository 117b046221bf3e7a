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
function ink(pen, line, fill, is_closed, weight) {
  const g = pen.g, fills = { none: "", white: css.bg, grey: css.grey, black: css.fg };
  if (is_closed) pen.close();
  if (fills[fill]) { g.fillStyle = fills[fill]; g.fill(); }
  g.strokeStyle = css.fg; g.lineWidth = LW[line] * weight; g.setLineDash(line === "dashed" ? [5, 4] : []); g.stroke();
}
const weight_of = symbol => Math.max(0.2, Math.min(1, symbol / 7));  // of lines, where symbols are so small, in pixels
function short(x, range = 0) {  // as many digits as tell the ends of a range from each other
  const a = Math.abs(x), more = range > 0 && a > 0 ? Math.min(9, Math.max(0, Math.ceil(Math.log10(a / range)))) : 0;
  return a === 0 || a < 1e-9 * range ? "0" : a >= 1e4 || a < 1e-3 ? x.toExponential(1 + more) : String(+x.toPrecision(3 + more));
}
const long = x => { const a = Math.abs(x); return a !== 0 && (a >= 1e7 || a < 1e-3) ? x.toExponential(5) : x.toPrecision(6); };
const brief = x => { const text = long(x); return text.includes("e") ? (+text).toExponential() : String(+text); };
const clock = (t, length) => (length < 0.1 ? t.toExponential(3) : t.toFixed(3)) + " s";
function other_theme() { const r = document.documentElement, dark = css.bg !== "#fff"; r.removeAttribute("data-dark"); r.removeAttribute("data-light"); r.setAttribute(dark ? "data-light" : "data-dark", ""); colours(); }
const SPEEDS = [1e-6, 1e-5, 1e-4, 0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.25, 0.5, 1, 2, 4, 10, 30, 100, 1000, 1e4, 1e5];
const beside = (speed, by) => SPEEDS[Math.max(0, Math.min(SPEEDS.length - 1, SPEEDS.indexOf(speed) + by))];
function faster(wanted) {  // the speed nearest to what is wanted becomes the chosen one
  if (!$("speed").options.length) for (const s of SPEEDS) $("speed").add(new Option(s + " ×", s));
  const speed = SPEEDS.reduce((a, b) => Math.abs(Math.log(b / wanted)) < Math.abs(Math.log(a / wanted)) ? b : a);
  $("speed").value = speed; return speed;
}
