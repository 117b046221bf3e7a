const D = JSON.parse(document.getElementById("data").textContent);
const F = text => new Float32Array(bytes(text));
const T = new Float64Array(bytes(D.t)), N = T.length;
for (const c of [...D.curves, ...D.energies]) { const y = F(c.y); c.y = c.base ? Float64Array.from(y, x => c.base + x) : y; }
if (!D.curves.length && !D.energies.length) document.querySelector("aside").style.display = "none";
let now = T[0], playing = false, last = 0, speed = 1;
const state = { loop: true, trace: true, names: true };

function place(t) {  // the row before t, and how far on it is
  let a = 0, b = N - 1; if (N < 2 || t <= T[0]) return [0, 0]; if (t >= T[b]) return [b, 0];
  while (b - a > 1) { const m = (a + b) >> 1; if (T[m] <= t) a = m; else b = m; }
  return [a, (t - T[a]) / (T[b] - T[a] || 1)];
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
const theme = () => { other_theme(); draw(); }; $("theme").onclick = theme;
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
function begin() {  // the script of the scene calls it
  watch(); fast(D.speed); colours(); draw();
  for (const c of $("curves").canvases) { c.onpointerdown = e => { c.setPointerCapture(e.pointerId); seek(e); }; c.onpointermove = e => { if (e.buttons) seek(e); }; }
}
window.lagrangia = { get time() { return now; }, go(t) { playing = false; now = t; draw(); }, get playing() { return playing; }, value(name) { return between(D.curves.find(c => c.name === name).y); } };
