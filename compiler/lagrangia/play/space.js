// A scene in space, as it is now, and its parts under the pointer.
for (const form of Object.values(D.forms)) form.v = new Float32Array(bytes(form.v));
const point_of = k => [rows[k], rows[k + 1], rows[k + 2]], WIDTH = 3, REACH = 16;  // pixels within which a part is taken, not the eye
let near = null;
function scene() {
  const { bodies, lines, names } = moment(D, rows);
  render(bodies.map(b => ({ ...D.forms[b.form], ...b })), lines, names, traces, running);
  if (held === null && near === null) return;
  const g = $("scene").getContext("2d"), [x, y] = window_of(point_of(held === null ? near : held));
  g.beginPath(); g.strokeStyle = css.hot; g.lineWidth = 1.5; g.arc(x, y, 7, 0, 2 * Math.PI); g.stroke();
}
const sides = () => [$("scene").clientWidth, $("scene").clientHeight], per_metre = () => scale_of(...sides());
const seen = (k, drawn) => axes().slice(0, 2).map(a => dot(a, drawn.slice(k, k + 3)));  // m, in the plane of view: how deep is left to the scene
const window_of = p => { const [w, h] = sides(), [u, v] = axes().map(a => per_metre() * dot(a, p.map((x, i) => x - middle[i]))); return [w / 2 + eye.x + u, h / 2 + eye.y - v]; };
function pointer(e) {
  const box = $("scene").getBoundingClientRect(), [w, h] = sides(), A = axes(), k = per_metre();
  return [dot(A[0], middle) + (e.clientX - box.left - w / 2 - eye.x) / k, dot(A[1], middle) - (e.clientY - box.top - h / 2 - eye.y) / k];
}
hand = {
  take: e => !e.shiftKey && e.button === 0 && grab(e, e.pointerType === "touch" ? 2 * REACH : REACH),
  move(e) {
    if (held !== null) { drag(e); return true; }
    const found = e.buttons || !now ? null : nearest(e, REACH);
    if (found !== near) { near = found; $("scene").style.cursor = near === null ? "" : "pointer"; draw(); }
    return false;
  },
  leave() { if (held !== null) { held = near = null; draw(); } },
};
$("scene").setAttribute("aria-label", "the mechanism in motion; it is turned, shifted and zoomed by hand, and parts can be dragged to where it starts");
if (D.movable.length) document.querySelector("nav small").prepend("a part follows where it is dragged; beside parts ");
