// The words of drawing sections in space -> solids and lines, as solids/seen.py has them: there the reasons stand. A test holds both together.
// Solids are stretched out of forms of size 1: D.forms, { v: [x, y, z, ...], f: faces, e: edges }.
const ONE = [[1, 0, 0], [0, 1, 0], [0, 0, 1]], SEGMENTS = 48;
const turned = A => ONE.map((_, i) => A.map(row => row[i]));  // the transposed one
const sized = (A, x, y, z) => A.map(row => [row[0] * x, row[1] * y, row[2] * z]);
function across(axis) {  // turns z into this direction
  const z = unit(axis), sizes = z.map(Math.abs), aside = ONE[sizes.indexOf(Math.min(...sizes))], a = dot(aside, z), x = unit(aside.map((e, i) => e - a * z[i]));
  return turned([x, cross(z, x), z]);
}
function aside_of(a, b) {  // how far b is from a, the way there, and a direction across it
  const way = b.map((x, i) => x - a[i]), n = Math.hypot(...way), z = n > 0 ? scaled(way, 1 / n) : [0, 0, 1];
  return { way, n, z, x: unit(cross(Math.abs(z[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0], z)) };
}
const size_of = g => g.o.size ? g.S * g.o.size[0] : g.S, axis_of = g => g.o.along || [0, 0, 1];
const upright = g => { const axis = axis_of(g); return axis[0] || axis[1] ? across(axis) : ONE; };
const number = (g, k, usual) => k < g.n.length ? Math.abs(g.n[k][0]) : usual;
const riding = (g, form, stretch, at = [0, 0, 0], shade = g.shade) => {
  const { p, R } = g.at[0];
  return { bodies: [{ form, s: shade, at: plus(p, times(R, at)), turn: product(R, stretch) }] };
};
const lined = (g, points) => ({ lines: [{ l: g.line, points }] });
const ring = (radius, begin, end, count) => Array.from({ length: count }, (_, k) => { const a = begin + (end - begin) * k / (count - 1); return [radius * Math.cos(a), radius * Math.sin(a), 0]; });
const hinge = g => unit(g.o.hinge || g.at[0].R.map(row => row[2]));  // the axis of a spring or damper of torsion
const in_place = (g, A, points) => lined(g, points.map(v => plus(g.at[0].p, times(g.at[0].R, times(A, v)))));
const ball = g => { const r = number(g, 0, 0.25 * size_of(g)); return riding(g, "sphere", sized(ONE, r, r, r)); };
function cylinder(g, r, h) { return riding(g, "cylinder", sized(upright(g), r, r, h)); }
function box(g) {
  const thick = g.n.length > 1 ? number(g, 1) : (g.n.length ? 0.25 : 0.5) * size_of(g), along = g.o.along || [1, 0, 0];
  const turn = along[1] || along[2] ? product(across(along), turned(across([1, 0, 0]))) : ONE;
  return riding(g, "box", sized(turn, number(g, 0, 0.6 * size_of(g)), thick, thick));
}
function zigzag(g) {
  if (!g.hinged) return lined(g, coil(g.at[0].p, g.at[1].p, 0.2 * g.S, g.turns));
  const [half, radius] = g.helix, [a, b] = [-1, 1].map(side => plus(g.at[0].p, scaled(hinge(g), side * half * g.S)));
  return lined(g, coil(a, b, radius * g.S, g.turns));
}
function brake(g) {
  const A = across(hinge(g)), shoe = ([radius, from, to]) => ring(radius * g.S, from * Math.PI / 180, to * Math.PI / 180, 13);
  return { lines: g.brake.map(part => ({ l: g.line, points: shoe(part).map(v => plus(g.at[0].p, times(A, v))) })) };
}
function dashpot(g) {
  if (g.hinged) return brake(g);
  const a = g.at[0].p, b = g.at[1].p, { way, x } = aside_of(a, b), at = (s, t) => a.map((p, i) => p + s * way[i] + t * g.S * x[i]);
  const parts = [[[0, 0], [0.35, 0]], [[0.65, 0.25], [0.35, 0.25], [0.35, -0.25], [0.65, -0.25]], [[0.5, 0.18], [0.5, -0.18]], [[0.5, 0], [1, 0]]];
  return { lines: parts.map(part => ({ l: g.line, points: part.map(([s, t]) => at(s, t)) })) };
}
function arrow(g) {
  if (!g.is_load && g.measure !== "length" || g.n[0].length !== 3) return {};
  const k = g.measure === "length" ? 1 : g.longest * g.S / (g.greatest || 1), a = g.at[0].p, b = plus(a, scaled(g.n[0], k)), { n, x, z } = aside_of(a, b);
  const head = Math.min(0.35 * g.S, 0.5 * n), way = n > 0 ? z : [0, 0, 0], barb = side => b.map((p, i) => p - head * (way[i] - side * 0.4 * x[i]));
  return { lines: [{ l: "thick", points: [a, b, barb(1), b, barb(-1)] }] };
}
function curved_arrow(g) {
  const value = g.n[0], { p, R } = g.at[0], radius = 0.8 * g.S, span = 1.5 * Math.PI;
  if (!g.is_load || Math.hypot(...value) === 0) return {};
  const A = across(value.length === 3 ? value : scaled(times(R, axis_of(g)), Math.sign(value[0])));
  const at = (u, v) => plus(p, times(A, [u, v, 0])), points = ring(radius, 0, span, 25).map(([u, v]) => at(u, v));
  const [c, s] = [Math.cos(span), Math.sin(span)], barb = side => at(radius * (c - 0.3 * (-s - side * c)), radius * (s - 0.3 * (c - side * s)));
  return { lines: [{ l: "thick", points: [...points, barb(0.5), points[24], barb(-0.5)] }] };
}
const way = g => lined(g, g.at.map(({ p }) => p));
const SHAPES = {
  line: way, polyline: way, rail: way, polygon: g => lined(g, [...g.at, g.at[0]].map(({ p }) => p)), ball, box, dashpot, zigzag, arrow, curved_arrow,
  circle(g) {
    if (!g.n.length) return ball(g);
    const r = number(g, 0);
    return g.fill === "none" ? in_place(g, across(axis_of(g)), ring(r, 0, 2 * Math.PI, SEGMENTS + 1)) : cylinder(g, r, 0.12 * r);
  },
  arc: g => in_place(g, ONE, ring(g.n[0][0], g.n[1][0], g.n[2][0], SEGMENTS)),
  cuboid: g => riding(g, "box", sized(ONE, number(g, 0, 0), number(g, 1, 0), number(g, 2, 0))),
  cylinder: g => cylinder(g, number(g, 0, 0.15 * size_of(g)), number(g, 1, 0.5 * size_of(g))),
  cone(g) { const r = number(g, 0, 0), h = number(g, 1, 0); return riding(g, "cone", sized(upright(g), r, r, h), times(upright(g), [0, 0, h / 4])); },
  hatch: g => g.ground ? riding(g, "box", sized(ONE, 0.8 * size_of(g), 0.8 * size_of(g), 0.1 * size_of(g)), [0, 0, 0], "grey") : {},
};
const all_finite = x => Array.isArray(x) ? x.every(all_finite) : typeof x !== "number" || isFinite(x);
const place_at = (rows, k) => ({ p: rows.slice(k, k + 3), R: [3, 6, 9].map(i => rows.slice(k + i, k + i + 3)) });
const between_rows = ([from, to], rows) => rows.slice(from, to);
// A page's data and the numbers of a moment -> { bodies, lines, names } as render() takes them, but for bodies' forms by their names.
function moment(data, rows) {
  rows = Array.from(rows);
  const found = { bodies: [], lines: [] };
  for (const figure of data.figures) {
    const g = { ...figure, S: data.symbol, longest: data.longest, helix: data.helix, brake: data.brake, at: figure.at.map(k => place_at(rows, k)), n: figure.n.map(n => between_rows(n, rows)), o: {} };
    for (const [name, span] of Object.entries(figure.o)) g.o[name] = between_rows(span, rows);
    if (![...g.at.flatMap(({ p, R }) => [p, R]), ...g.n, ...Object.values(g.o)].every(all_finite)) continue;
    const shape = SHAPES[g.word](g);
    found.bodies.push(...shape.bodies || []); found.lines.push(...shape.lines || []);
  }
  for (const ends of data.rods) found.lines.push({ l: "thick", points: ends.map(k => rows.slice(k, k + 3)) });
  found.lines = found.lines.filter(({ points }) => all_finite(points));
  found.names = data.names.map(({ words, at }) => ({ words, at: [0, 1, 2].map(i => at.reduce((s, k) => s + rows[k + i], 0) / at.length) }));
  return found;
}
