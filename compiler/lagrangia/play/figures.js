// The words of drawing sections -> strokes, as draw/strokes.py has them: there the reasons stand. A test holds both together.
// A stroke: { p: [x, y, x, y, ...] in m, layer, l: line, f: fill, c: closed, r: radius in m or 0 }; a spot: [x, y, aside x, aside y].
const [RAILS, RODS, SPRINGS, BODIES, HINGES, ARROWS] = [0, 1, 2, 3, 4, 5], ARC = 6 * (Math.PI / 180);
const stroke = (p, layer, l = "normal", f = "none", c = false, r = 0) => ({ p, layer, l, f, c, r });
const hypot = Math.hypot, clip = (x, a, b) => Math.min(Math.max(x, a), b);
const even = x => { const n = Math.round(x); return Math.abs(x - Math.trunc(x)) === 0.5 ? 2 * Math.round(x / 2) : n; };  // as Python rounds
function way_of(g) {
  const [x, y] = g.o.along || [1, 0], n = hypot(x, y), a = g.at[0][2], c = Math.cos(a), s = Math.sin(a), u = n > 0 ? x / n : 1, v = n > 0 ? y / n : 0;
  return [c * u - s * v, s * u + c * v];
}
const size_of = g => g.S * (g.o.size ? g.o.size[0] : 1);
const number = (g, k) => k < g.n.length ? g.n[k][0] : null;
function arc_points(x, y, radius, begin, end) {
  const count = Math.min(Math.max(2, Math.trunc(Math.abs(end - begin) / ARC) + 2), 400), p = [];
  for (let i = 0; i < count; i++) { const a = i === count - 1 ? end : begin + i * (end - begin) / (count - 1); p.push(x + radius * Math.cos(a), y + radius * Math.sin(a)); }
  return p;
}
function ends_of(g) {
  const [[ax, ay], [bx, by]] = g.at, n = hypot(bx - ax, by - ay), w = n > 0 ? [(bx - ax) / n, (by - ay) / n] : [1, 0];
  const [s, e] = g.trims, hidden = Math.min(1, n / (s + e || 1));
  const a = [ax + hidden * s * w[0], ay + hidden * s * w[1]], b = [bx - hidden * e * w[0], by - hidden * e * w[1]];
  return { a, b, w, u: [-w[1], w[0]], n: hypot(b[0] - a[0], b[1] - a[1]) };
}
// Places along a line and across it, [x, y, x, y, ...].
const along = (e, list) => { const p = []; for (let i = 0; i < list.length; i += 2) p.push(e.a[0] + list[i] * e.w[0] + list[i + 1] * e.u[0], e.a[1] + list[i] * e.w[1] + list[i + 1] * e.u[1]); return p; };
function laned(g, strokes, e, width) {
  const s = g.lane * g.S, x = s * e.u[0], y = s * e.u[1];
  if (g.lane) {
    for (const k of strokes) k.p = k.p.map((v, i) => v + (i % 2 ? y : x));
    for (const [u, v] of [e.a, e.b]) strokes.push(stroke([u, v, u + x, v + y], SPRINGS, g.line));
  }
  const t = g.lane >= 0 ? 1 : -1;
  return { strokes, spot: [(e.a[0] + e.b[0]) / 2 + x + t * e.u[0] * width, (e.a[1] + e.b[1]) / 2 + y + t * e.u[1] * width, t * e.u[0], t * e.u[1]] };
}
function spiral(g) {
  const [x, y] = g.at[0], p = [], whole = 5.2 * Math.PI, count = Math.ceil(whole / ARC), last = (count - 1) * ARC;
  for (let i = 0; i < count; i++) { const a = i * ARC, r = g.S * (0.25 + 0.65 * a / last); p.push(x + r * Math.cos(a), y + r * Math.sin(a)); }
  return { strokes: [stroke(p, HINGES, "thin")], spot: [p[p.length - 2], p[p.length - 1], 1, 0.5] };
}
function zigzag(g) {
  const e = ends_of(g), n = e.n;
  if (n < 0.3 * g.S) return spiral(g);
  const span = 0.7 * Math.max(g.ref, n), count = 2 * clip(even(span / (0.5 * g.S)), 5, 14), wire = hypot(span / count, 0.6 * g.S);
  const width = clip(Math.sqrt(Math.max(wire ** 2 - (0.7 * n / count) ** 2, 0)) / 2, 0.05 * g.S, 0.75 * g.S), list = [0, 0, 0.15 * n, 0];
  for (let i = 0; i < count; i++) list.push((0.15 + 0.7 * (i + 0.5) / count) * n, i % 2 ? -width : width);
  return laned(g, [stroke(along(e, [...list, 0.85 * n, 0, n, 0]), SPRINGS, g.line)], e, width);
}
function dashpot(g) {
  const e = ends_of(g), n = e.n;
  if (n < 0.3 * g.S) {
    const [x, y] = g.at[0], r = 0.8 * g.S, deg = Math.PI / 180;
    return { strokes: [[1, 200, 110], [0.75, 225, 60]].map(([k, a, d]) => stroke(arc_points(x, y, r * k, a * deg, (a + d) * deg), HINGES, g.line)), spot: [x - 0.6 * r, y - 0.8 * r, -0.6, -0.8] };
  }
  const whole = Math.max(g.ref, n), begin = 0.25 * n, end = n > 0.4 * whole ? Math.min(begin + 0.4 * whole, 0.8 * n) : 0.8 * n;
  const room = 0.15 * (end - begin), piston = clip(n - 0.45 * whole, begin + room, end - room), h = 0.26 * g.S;
  const lists = [[0, 0, begin, 0], [end, h, begin, h, begin, -h, end, -h], [piston, 0.75 * h, piston, -0.75 * h], [piston, 0, n, 0]];
  return laned(g, lists.map(list => stroke(along(e, list), SPRINGS, g.line)), e, h);
}
function circle(g) {
  const own = number(g, 0), r = own === null ? 0.5 * size_of(g) : Math.abs(own), [x, y] = g.at[0], has_room = r > g.S && g.fill !== "black" && r > 0;
  return { strokes: [stroke([x, y], r <= 0.3 * g.S ? HINGES : BODIES, g.line, g.fill, true, r)],
    spot: has_room ? [x, y + 0.45 * r, 0, 0] : [x + 0.6 * r, y + 0.8 * r, 0.6, 0.8] };
}
function box(g) {
  const length = number(g, 0), height = number(g, 1), slim = length !== null && height === null, size = size_of(g);
  const h = [length === null ? size : 0.5 * length, height !== null ? 0.5 * height : (slim ? 0.2 : 0.7) * size];
  const w0 = way_of(g), a = g.o.angle ? g.o.angle[0] : 0, c = Math.cos(a), s = Math.sin(a), w = [c * w0[0] - s * w0[1], s * w0[0] + c * w0[1]], u = [-w[1], w[0]];
  const e = { a: g.at[0], w, u }, [x, y] = g.at[0];
  const list = g.line === "round" ? [...arc_points(h[0], 0, h[1], -Math.PI / 2, Math.PI / 2), ...arc_points(-h[0], 0, h[1], Math.PI / 2, 1.5 * Math.PI)] : [h[0], h[1], -h[0], h[1], -h[0], -h[1], h[0], -h[1]];
  const spot = slim || !h[0] ? [x + u[0] * h[1] + 0.3 * h[0] * w[0], y + u[1] * h[1] + 0.3 * h[0] * w[1], u[0], u[1]] : [x, y, 0, 0];
  return { strokes: [stroke(along(e, list), BODIES, g.line === "round" ? "normal" : g.line, g.fill, true)], spot };
}
function head(x, y, w, size) {
  const bx = x - size * w[0], by = y - size * w[1], t = 0.35 * size;
  return stroke([x, y, bx - t * w[1], by + t * w[0], bx + t * w[1], by - t * w[0]], ARROWS, "thin", "black", true);
}
function headed(ax, ay, bx, by, S, line, has_foot) {
  const n = hypot(bx - ax, by - ay);
  if (n === 0) return { strokes: [], spot: null };
  const w = [(bx - ax) / n, (by - ay) / n], size = Math.min(0.45 * S, 0.6 * n), x = -0.3 * S * w[1], y = 0.3 * S * w[0];
  const strokes = [stroke([ax, ay, bx - 0.8 * size * w[0], by - 0.8 * size * w[1]], ARROWS, line), head(bx, by, w, size)];
  if (has_foot) strokes.push(stroke([ax + x, ay + y, ax - x, ay - y], ARROWS, "thin"));
  return { strokes, spot: [bx, by, w[0] - w[1], w[1] + w[0]] };
}
function arrow(g) {
  const [vx, vy] = g.n[0], value = hypot(vx, vy), S = g.S;
  let [x, y] = g.at[0];
  if (value === 0) return { strokes: [], spot: null };
  const w = [vx / value, vy / value];
  if (g.measure === "direction") {
    const t = 1.25 * S * (w[0] >= 0 ? 1 : -1);
    x += -w[1] * t; y += w[0] * t;
    return headed(x, y, x + 1.4 * S * w[0], y + 1.4 * S * w[1], S, "thin", true);
  }
  if (g.measure === "length") return headed(x, y, x + vx, y + vy, S, g.line, false);
  const n = g.ref > 0 ? S * (0.6 + 2.4 * Math.min(1, value / g.ref)) : 2.5 * S, free = g.trims[0], sign = w[0] > 0 ? 1 : -1;
  if (free > 0 && Math.abs(w[0]) > 0.5) { x += -0.5 * S * sign * w[1]; y += 0.5 * S * sign * w[0]; }
  const from = vy >= -0.5 * value ? free : -free - n;
  x += from * w[0]; y += from * w[1];
  return { strokes: headed(x, y, x + n * w[0], y + n * w[1], S, "thick", false).strokes, spot: [x + w[0] * n / 2, y + w[1] * n / 2, -w[1], w[0]] };
}
function curved_arrow(g) {
  const [x, y, phi] = g.at[0], value = g.n[0][0], S = g.S, deg = Math.PI / 180, sign = value >= 0 ? 1 : -1;
  if (g.measure === "angle") {
    const begin = phi + Math.atan2(g.lean[1], g.lean[0]), r = 1.9 * S;
    const shown = clip(Math.abs(value) > 8 * deg ? value : 28 * deg * (value > 0 ? 1 : value < 0 ? -1 : 1), -1.75 * Math.PI, 1.75 * Math.PI);
    const shape = round_headed(arc_points(x, y, r, begin, begin + shown), S, "thin", x, y);
    shape.strokes.unshift(stroke([x, y, x + 1.25 * r * Math.cos(begin), y + 1.25 * r * Math.sin(begin)], RAILS, "dashed"));
    return shape;
  }
  const sweep = g.ref > 0 ? deg * (60 + 170 * Math.min(1, Math.abs(value) / g.ref)) : 200 * deg;
  const r = g.trims[0] || g.trims[1] ? g.trims[0] + 0.5 * S : 1.15 * S, middle = 60 * deg;
  return round_headed(arc_points(x, y, r, middle - sign * sweep / 2, middle + sign * sweep / 2), S, "thick", x, y);
}
function round_headed(p, S, line, x, y) {
  const n = p.length / 2, gone = [0];
  for (let i = 1; i < n; i++) gone.push(gone[i - 1] + hypot(p[2 * i] - p[2 * i - 2], p[2 * i + 1] - p[2 * i - 1]));
  const size = Math.min(0.4 * S, 0.6 * gone[n - 1]), end = Math.max(0, gone[n - 1] - 0.9 * size), kept = [];
  let i = 0;
  for (; i < n && gone[i] < end; i++) kept.push(p[2 * i], p[2 * i + 1]);
  const j = Math.max(i, 1), f = (end - gone[j - 1]) / (gone[j] - gone[j - 1] || 1), bx = p[2 * j - 2] + f * (p[2 * j] - p[2 * j - 2]), by = p[2 * j - 1] + f * (p[2 * j + 1] - p[2 * j - 1]);
  kept.push(bx, by);
  const tx = p[2 * n - 2], ty = p[2 * n - 1], gap = hypot(tx - bx, ty - by), w = gap > 0 ? [(tx - bx) / gap, (ty - by) / gap] : [1, 0], m = 2 * (n >> 1);
  return { strokes: [...(kept.length > 2 ? [stroke(kept, ARROWS, line)] : []), head(tx, ty, w, size)], spot: [p[m], p[m + 1], p[m] - x, p[m + 1] - y] };
}
function hatched(x, y, w, half, S) {  // the ground is to the right of the way
  const count = clip(even(2 * half / (0.4 * S)), 2, 200), sx = -0.4 * S * w[0] + 0.4 * S * w[1], sy = -0.4 * S * w[1] - 0.4 * S * w[0];
  const found = [stroke([x - half * w[0], y - half * w[1], x + half * w[0], y + half * w[1]], RAILS)];
  for (let i = 1; i <= count; i++) { const t = -half + 2 * half * i / count, u = x + t * w[0], v = y + t * w[1]; found.push(stroke([u, v, u + sx, v + sy], RAILS, "thin")); }
  return found;
}
function hatch(g) {
  const [x, y] = g.at[0], size = size_of(g);
  if (!g.ground) return { strokes: [], spot: null };
  if (g.o.along) return { strokes: hatched(x, y, way_of(g), 1.5 * size, g.S), spot: null };
  const d = g.lean, fx = x + 0.85 * size * d[0], fy = y + 0.85 * size * d[1], u = [-d[1], d[0]], layer = g.trims[0] > g.S ? HINGES : RODS;
  const ground = hatched(fx, fy, u, size, g.S);
  if (layer === HINGES) for (const s of ground) s.layer = Math.max(layer, s.layer);
  return { strokes: [stroke([x, y, fx + 0.6 * size * u[0], fy + 0.6 * size * u[1], fx - 0.6 * size * u[0], fy - 0.6 * size * u[1]], layer, "normal", "white", true), ...ground], spot: null };
}
function rail(g) {
  const w = way_of(g);
  let u = [w[1], -w[0]];
  if (u[1] > 1e-6) u = [-u[0], -u[1]];
  const off = g.o.offset ? 0.7 * g.S * g.o.offset[0] : 0, low = g.reach[0] - 1.7 * g.S, high = g.reach[1] + 1.7 * g.S, m = (low + high) / 2, h = (high - low) / 2;
  const x = g.at[0][0] + off * u[0] + m * w[0], y = g.at[0][1] + off * u[1] + m * w[1];
  if (g.ground) return { strokes: hatched(x, y, w[1] * u[0] - w[0] * u[1] > 0 ? w : [-w[0], -w[1]], h, g.S), spot: null };
  return { strokes: [stroke([x - h * w[0], y - h * w[1], x + h * w[0], y + h * w[1]], RAILS, "thin")], spot: null };
}
function wheels(g, is_crossed) {
  const r = [0, 1].map(k => Math.abs(number(g, k) || 0)), [[ax, ay], [bx, by]] = g.at, x = bx - ax, y = by - ay, n = hypot(x, y);
  const strokes = [stroke([ax, ay], HINGES, "dashed", "none", true, r[0]), stroke([bx, by], HINGES, "dashed", "none", true, r[1])];
  if (!is_crossed && n > Math.abs(r[0] - r[1])) for (const sign of [1, -1]) {
    const a = sign * Math.acos((r[0] - r[1]) / n), c = Math.cos(a), s = Math.sin(a), u = (c * x - s * y) / n, v = (s * x + c * y) / n;
    strokes.push(stroke([ax + r[0] * u, ay + r[0] * v, bx + r[1] * u, by + r[1] * v], HINGES));
  }
  return { strokes, spot: null };
}
const points_of = g => g.at.flatMap(([x, y]) => [x, y]);
const middle = g => [g.at.reduce((s, p) => s + p[0], 0) / g.at.length, g.at.reduce((s, p) => s + p[1], 0) / g.at.length];
const SHAPES = {
  line(g) { const e = ends_of(g); return { strokes: [stroke([...e.a, ...e.b], g.line === "thin" || g.line === "dashed" ? HINGES : RODS, g.line)], spot: [(e.a[0] + e.b[0]) / 2, (e.a[1] + e.b[1]) / 2, ...e.u] }; },
  polyline: g => ({ strokes: [stroke(points_of(g), RODS, g.line)], spot: [...middle(g), 0, 1] }),
  polygon: g => ({ strokes: [stroke(points_of(g), BODIES, g.line, g.fill, true)], spot: [...middle(g), 0, size_of(g) > 0 ? 0 : 1] }),
  circle, box, zigzag, dashpot, arrow, curved_arrow, hatch, rail, gears: g => wheels(g, true), belt: g => wheels(g, false),
  text: g => ({ strokes: [], spot: [g.at[0][0], g.at[0][1], 0, 1] }),
  arc(g) {
    const [x, y, phi] = g.at[0], p = arc_points(x, y, number(g, 0) || 0, phi + (number(g, 1) || 0), phi + (number(g, 2) || 0)), m = 2 * (p.length >> 2);
    return { strokes: [stroke(p, RODS, g.line)], spot: [p[m], p[m + 1], p[m] - x, p[m + 1] - y] };
  },
};
// A figure of the page's data and the numbers of a moment -> its shape, with the ground that holds its ends.
function shape_of(figure, rows, S) {
  const g = { S, at: figure.at.map(([k, x, y]) => [rows[k] + x, rows[k + 1] + y, rows[k + 2]]), n: figure.n.map(n => n.map(k => rows[k])), o: {},
    fill: figure.fill, line: figure.line, trims: figure.trims, ref: figure.ref, measure: figure.measure, lane: figure.lane, ground: figure.ground, reach: figure.reach, lean: figure.lean };
  for (const [name, list] of Object.entries(figure.o)) g.o[name] = list.map(k => rows[k]);
  if (![...g.at, ...g.n, ...Object.values(g.o)].every(list => list.every(isFinite))) return { strokes: [], spot: null };
  const shape = SHAPES[figure.word](g);
  for (const [j, wx, wy] of figure.held) {
    const [x, y] = g.at[j];
    shape.strokes.push(...hatched(x, y, [wy, -wx], 1.3 * S, S));
  }
  return shape;
}
const extent = s => { let lx = Infinity, ly = Infinity, hx = -Infinity, hy = -Infinity; if (s.f === "none") return 2 * s.r; for (let i = 0; i < s.p.length; i += 2) { lx = Math.min(lx, s.p[i]); hx = Math.max(hx, s.p[i]); ly = Math.min(ly, s.p[i + 1]); hy = Math.max(hy, s.p[i + 1]); } return 2 * s.r + Math.max(hx - lx, hy - ly); };
// All of a moment: strokes in the order in which they are drawn, named [words, x, y, aside x, aside y] or null where there is nothing.
function picture(data, rows) {
  const strokes = [], named = [];
  for (const figure of data.figures) {
    const shape = shape_of(figure, rows, data.symbol);
    for (const s of shape.strokes) strokes.push([s.layer, -extent(s), strokes.length, s]);
    if (figure.words) { const [x, y, u, v] = shape.spot || [], n = hypot(u, v) || 1; named.push(shape.spot && [figure.words, x, y, u / n, v / n]); }
  }
  for (const [[a, ax, ay], [b, bx, by]] of data.arms) {
    const p = [rows[a] + ax, rows[a + 1] + ay, rows[b] + bx, rows[b + 1] + by];
    if (hypot(p[2] - p[0], p[3] - p[1]) > data.shortest * data.symbol) strokes.push([RODS, 0, strokes.length, stroke(p, RODS, "thick")]);
  }
  strokes.sort((a, b) => a[0] - b[0] || a[1] - b[1] || a[2] - b[2]);
  return { strokes: strokes.map(s => s[3]), named };
}
