const D = JSON.parse($("data").textContent), S = D.symbol, WINDOW = D.window || 1, MOST_ROWS = 6000;
const state = { trace: true, names: true };
const given = new Map(D.given);  // what is not as declared, by reference
let machine, now, rows, T, curves, traces, events, least, most, low, high, running = false, failed = false, last = 0, speed = 1, view = null;

function tell(text) { $("told").textContent = text; }
function restart() {  // from the start, with all that is given
  failed = !machine.begin(given, D.tolerance, D.stop);
  if (failed) { running = false; tell(machine.message); }
  else tell("");
  T = []; events = []; curves = D.curves.map(c => ({ ...c, y: [] })); traces = D.traces.map(() => []); least = most = 0; low = [...D.low]; high = [...D.high];
  look(); return !failed;
}
function look() {  // what the run time has now becomes a row of the page
  if (failed) return;
  const found = machine.values(), drawn = machine.drawing();
  if (!found || !drawn) { failed = true; running = false; tell(machine.message); return; }
  [now, rows] = [found, drawn];
  if (T.length && T[T.length - 1] === now[0]) { T.pop(); for (const c of curves) c.y.pop(); for (const t of traces) t.length -= 2; }
  T.push(now[0]);
  for (const c of curves) c.y.push(now[c.ref] * c.scale);
  D.traces.forEach(([, k, x, y], i) => traces[i].push(rows[k] + x, rows[k + 1] + y));
  const V = now[D.energies[1].ref], sum = D.energies.reduce((s, e) => s + now[e.ref], 0);
  least = Math.min(least, V); most = Math.max(most, sum - least);
  if (events.length > MOST_ROWS) events = events.slice(-MOST_ROWS / 2);
  if (T.length > MOST_ROWS) { const half = (list, width) => list.filter((_, i) => (i / width | 0) % 2 === 0); T = half(T, 1); for (const c of curves) c.y = half(c.y, 1); traces = traces.map(t => half(t, 2)); }
}
function advance(h) {  // in pieces that curves can show; false when the run stops
  const pieces = Math.min(2000, Math.max(1, Math.ceil(h / (WINDOW / 500))));
  const from = now[0];
  for (let i = 1; i <= pieces && !failed; i++) {
    if (machine.step(from + h * i / pieces - now[0])) { look(); events.push(...machine.events()); }
    else { failed = true; running = false; tell(machine.message); }
  }
  return !failed;
}
function change(control, value) {
  const is_same = value === control.value;
  if (is_same) given.delete(control.ref); else given.set(control.ref, value);
  control.now = value; show(control);
  if (control.kind === "start" || failed || now[0] === D.start) restart();
  else if (machine.set(control.ref, value)) { look(); machine.events(); events = events.filter(t => t <= now[0]); }  // that is none of the scene
  else { const why = machine.message; restart(); tell(why); }
  draw();
}
function show(control) {
  const shown = Math.abs(control.now) < 1e-12 * (control.high - control.low) ? 0 : control.now * control.scale;  // what is rounding
  control.range.value = shown; if (document.activeElement !== control.field) control.field.value = brief(shown);
}
function controls() {
  for (const [kind, title] of [["input", "inputs"], ["parameter", "parameters"], ["start", "start"]]) {
    const own = D.controls.filter(c => c.kind === kind);
    if (!own.length) continue;
    const group = document.createElement("details"), head = document.createElement("summary");
    head.textContent = title; group.append(head); group.open = own.length <= 12; $("controls").append(group);
    for (const c of own) {
      const label = document.createElement("label"), name = document.createElement("span"), side = document.createElement("span"), unit = document.createElement("small");
      [c.range, c.field] = ["range", "number"].map(type => { const i = document.createElement("input"); i.type = type; i.step = "any"; i.setAttribute("aria-label", c.name); return i; });
      c.range.min = c.low * c.scale; c.range.max = c.high * c.scale; c.now = given.has(c.ref) ? given.get(c.ref) : c.value;
      name.textContent = c.name + (c.varies ? " (over time)" : ""); label.title = c.about; unit.textContent = " " + c.unit;
      side.append(c.field, unit); label.append(name, side, c.range); group.append(label);
      c.range.oninput = () => change(c, c.range.value / c.scale);
      c.field.onchange = () => { if (isFinite(c.field.valueAsNumber)) change(c, c.field.valueAsNumber / c.scale); else show(c); };
      show(c);
    }
  }
  const group = document.createElement("details"), table = document.createElement("table");
  group.open = true; group.innerHTML = "<summary>now</summary>"; group.append(table); $("controls").prepend(group);
  D.shown.forEach(v => { const row = table.insertRow(); row.insertCell().textContent = v.name; v.cell = row.insertCell(); });
}
// ------------------------------------------------------------ drawing
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
function draw() {
  scene();
  const t = now[0], from = Math.max(D.start, t - WINDOW), first = T.findIndex(u => u >= from);
  graphs($("curves"), curves.map(c => ({ name: c.name, unit: c.unit, y: c.y.slice(first), now: now[c.ref] * c.scale })), T.slice(first), T.length - first, from, from + WINDOW, t, events.filter(u => u <= t));
  bars($("energy"), D.energies.map((e, i) => ({ name: e.name, least: i === 1 ? least : 0, value: now[e.ref] })), most);
  for (const v of D.shown) v.cell.textContent = long(now[v.ref] * v.scale) + " " + v.unit;
  $("now").textContent = "t = " + clock(t, WINDOW); $("play").innerHTML = running ? "&#10074;&#10074;" : "&#9654;";
}
// ------------------------------------------------------------ time
function tick(ms) {
  if (!running) return;
  const h = Math.min((ms - last) / 1000, 0.1) * speed; last = ms;
  if (h > 0) advance(h);
  draw(); requestAnimationFrame(tick);
}
function play() { if (failed && !restart()) { draw(); return; } running = !running; if (running) { last = performance.now(); requestAnimationFrame(tick); } draw(); }
function ahead() { running = false; if (!failed) advance(speed / 30); draw(); }
function reset() { running = false; restart(); draw(); }
function defaults() { running = false; given.clear(); for (const c of D.controls) { c.now = c.value; show(c); } restart(); draw(); }
function toggle(id) { state[id] = !state[id]; $(id).setAttribute("aria-pressed", state[id]); draw(); }
const fast = s => { speed = faster(s); };
const theme = () => { other_theme(); draw(); };
// ------------------------------------------------------------ dragging: the start at which a frame is nearest to the pointer
let held = null;
const pointer = e => { const box = $("scene").getBoundingClientRect(); return [view.x(e.clientX - box.left), view.y(e.clientY - box.top)]; };
const place_of = ([k, x, y], drawn) => [drawn[k] + x, drawn[k + 1] + y];
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
async function open_page() {
  colours();
  machine = await Machine.made(D.program, D.image, D.sizes, D.inputs);
  controls(); fast(D.speed);
  if (!restart()) { const why = machine.message; given.clear(); restart(); tell(why); }
  $("play").onclick = play; $("ahead").onclick = ahead; $("reset").onclick = reset; $("defaults").onclick = defaults; $("theme").onclick = theme;
  $("speed").onchange = e => { speed = +e.target.value; };
  for (const id of ["trace", "names"]) $(id).onclick = () => toggle(id);
  if (!D.traces.length) $("trace").hidden = true;
  const canvas = $("scene");
  canvas.onpointerdown = grab; canvas.onpointermove = drag; canvas.onpointerup = canvas.onpointercancel = () => { held = null; };
  document.onkeydown = e => {
    if (e.ctrlKey || e.metaKey || e.altKey || ["SELECT", "INPUT"].includes(e.target.tagName)) return;
    const does = { " ": play, ArrowRight: ahead, r: reset, t: () => toggle("trace"), n: () => toggle("names"), d: theme,
      "+": () => fast(beside(speed, 1)), "-": () => fast(beside(speed, -1)) }[e.key];
    if (does) { e.preventDefault(); does(); }
  };
  addEventListener("resize", draw); matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { colours(); draw(); });
  draw();
}
const control = name => D.controls.find(c => c.name === name);
window.lagrangia = {
  ready: open_page().catch(e => { tell(String(e.message || e)); throw e; }),
  get time() { return now[0]; }, get running() { return running; }, get message() { return $("told").textContent; },
  value: name => now[D.shown.find(v => v.name === name).ref], set: (name, value) => change(control(name), value),
  go(t) { running = false; const ok = t > now[0] ? advance(t - now[0]) : true; draw(); return ok; }, reset,
};
