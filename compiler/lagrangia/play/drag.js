// A part that is dragged: the start at which it is nearest to the pointer, as it is seen. Of pages of the plane and of space.
let held = null;
const is_begun = D.is_looped || D.movable.some(m => m.refs.length > 1);  // where other numbers follow from those that are moved
const parts = D.movable.flatMap(m => Array(m.refs.length > 1 ? 3 : 1).fill(m));  // one number each, three for an attitude
function nearest(e, reach) {  // the frame nearest to the pointer, unless that is further away, in pixels
  const [x, y] = pointer(e), far = D.frames.map(f => { const [u, v] = seen(f, rows); return Math.hypot(u - x, v - y); }), best = far.indexOf(Math.min(...far));
  return D.movable.length && best >= 0 && far[best] * per_metre() <= reach ? D.frames[best] : null;
}
function grab(e, reach) {
  held = now ? nearest(e, reach) : null;
  if (held !== null) $("scene").setPointerCapture(e.pointerId);
  return held !== null;
}
function placed(values, asked) {  // coordinates, and turns of attitudes from where they are now
  let i = 0;
  for (const { refs } of D.movable) {
    if (refs.length === 1) { asked.set(refs[0], values[i++]); continue; }
    const quaternion = attitude_from(refs.map(ref => now[ref]), values.slice(i, i += 3));
    refs.forEach((ref, k) => asked.set(ref, quaternion[k]));
  }
  return asked;
}
function posed(values) {  // the numbers of the drawing there; in a loop the other coordinates follow as they do at a start
  if (is_begun) return machine.begin(placed(values, new Map(given)), D.tolerance, D.stop) ? machine.drawing() : null;
  const q = now.slice(1, 1 + D.n);
  parts.forEach(({ refs }, i) => { q[refs[0] - 1] = values[i]; });
  return machine.drawing(q);
}
function drag(e) {
  if (held === null || !now) return;
  running = false;
  const target = pointer(e), tiny = is_begun ? 1e-5 : 1e-6;
  let values = parts.map(({ refs }) => refs.length > 1 ? 0 : now[refs[0]]), best = null;
  for (let round = 0; round < (is_begun ? 3 : 8); round++) {  // least squares with little damping: one point, many coordinates
    const at = posed(values);
    if (!at) break;
    best = values;
    const [x, y] = seen(held, at), gap = [target[0] - x, target[1] - y], J = [];
    for (let i = 0; i < parts.length; i++) {
      const h = tiny * parts[i].size, other = posed(values.map((v, j) => j === i ? v + h : v)), [u, v] = other ? seen(held, other) : [x, y];
      J.push([(u - x) / tiny, (v - y) / tiny]);
    }
    let a = 1e-6 * S * S, b = 0, d = a;
    for (const [u, v] of J) { a += u * u; b += u * v; d += v * v; }
    const det = a * d - b * b, u = (d * gap[0] - b * gap[1]) / det, v = (a * gap[1] - b * gap[0]) / det;
    values = values.map((q, i) => q + parts[i].size * Math.min(0.3, Math.max(-0.3, J[i][0] * u + J[i][1] * v)));
  }
  if (posed(values)) best = values;
  const before = new Map(given);
  if (best) placed(best, given);
  if (!restart()) { const why = machine.message; given.clear(); for (const [ref, value] of before) given.set(ref, value); restart(); tell(why); }
  for (const c of D.controls) if (c.kind === "start" && D.movable.some(m => m.refs[0] === (c.refs || [c.ref])[0])) follow(c);
  draw();
}
function follow(c) {  // a slider, to what its start is now
  if (c.refs) { c.base = c.refs.map((ref, k) => given.has(ref) ? given.get(ref) : c.quaternion[k]); c.now = 0; } else if (given.has(c.ref)) c.now = given.get(c.ref);
  show(c);
}
