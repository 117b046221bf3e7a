const D = JSON.parse($("data").textContent), S = D.symbol, WINDOW = D.window || 1, MOST_ROWS = 6000;
const state = { trace: true, names: true };
const given = new Map(D.given);  // what is not as declared, by reference
let machine, now, rows, T, curves, traces, events, least, most, low, high, running = false, failed = false, last = 0, speed = 1;

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
  if (T.length && T[T.length - 1] === now[0]) { T.pop(); for (const c of curves) c.y.pop(); for (const t of traces) t.length -= WIDTH; }
  T.push(now[0]);
  for (const c of curves) c.y.push(now[c.ref] * c.scale);
  D.traces.forEach((trace, i) => traces[i].push(...point_of(trace)));
  const V = now[D.energies[1].ref], sum = D.energies.reduce((s, e) => s + now[e.ref], 0);
  least = Math.min(least, V); most = Math.max(most, sum - least);
  if (events.length > MOST_ROWS) events = events.slice(-MOST_ROWS / 2);
  if (T.length > MOST_ROWS) { const half = (list, width) => list.filter((_, i) => (i / width | 0) % 2 === 0); T = half(T, 1); for (const c of curves) c.y = half(c.y, 1); traces = traces.map(t => half(t, WIDTH)); }
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
  control.now = value; show(control);
  if (control.refs) turn(control);
  else if (value === control.value) given.delete(control.ref);
  else given.set(control.ref, value);
  if (control.kind === "start" || failed || now[0] === D.start) restart();
  else if (machine.set(control.ref, value)) { look(); machine.events(); events = events.filter(t => t <= now[0]); }  // that is none of the scene
  else { const why = machine.message; restart(); tell(why); }
  draw();
}
function attitude_from([b, u, v, w], turn) {  // a quaternion, by a vector: an angle along an axis
  const half = turn.map(x => x / 2), n = Math.hypot(...half), s = n > 0 ? Math.sin(n) / n : 1, a = Math.cos(n), [x, y, z] = half.map(h => s * h);
  return [a * b - x * u - y * v - z * w, a * u + x * b + y * w - z * v, a * v + y * b + z * u - x * w, a * w + z * b + x * v - y * u];
}
function turn(control) {  // an attitude, from the base of its three sliders
  const own = D.controls.filter(c => c.refs && c.refs[0] === control.refs[0]), by = own.map(c => c.now), found = attitude_from(control.base, by);
  const is_declared = by.every(x => x === 0) && control.base === control.quaternion;
  control.refs.forEach((ref, i) => { if (is_declared) given.delete(ref); else given.set(ref, found[i]); });
  for (const c of own) c.base = control.base;
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
      if (c.refs) c.base = given.has(c.refs[0]) ? c.refs.map(ref => given.get(ref)) : c.quaternion;
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
function defaults() { running = false; given.clear(); for (const c of D.controls) { c.now = c.value; c.base = c.quaternion; show(c); } restart(); draw(); }
function toggle(id) { state[id] = !state[id]; $(id).setAttribute("aria-pressed", state[id]); draw(); }
const fast = s => { speed = faster(s); };
const theme = () => { other_theme(); draw(); };
async function open_page() {
  colours();
  machine = await Machine.made(D.program, D.image, D.sizes, D.inputs);
  controls(); fast(D.speed);
  if (!restart()) { const why = machine.message; given.clear(); restart(); tell(why); }
  $("play").onclick = play; $("ahead").onclick = ahead; $("reset").onclick = reset; $("defaults").onclick = defaults; $("theme").onclick = theme;
  $("speed").onchange = e => { speed = +e.target.value; };
  for (const id of ["trace", "names"]) $(id).onclick = () => toggle(id);
  if (!D.traces.length) $("trace").hidden = true;
  watch();
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
