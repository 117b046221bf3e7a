// A run in space: poses of solids, places of lines over time.
for (const b of D.bodies) { b.v = F(b.v); b.poses = F(b.poses); }
for (const l of D.lines) l.points = F(l.points);
for (const c of D.captions) c.at = F(c.at);
for (const t of D.traces) t.at = F(t.at);
function pose_of(b, i, j, f) {
  const p = [], a = 7 * i, c = 7 * j; let same = 0;
  for (let k = 3; k < 7; k++) same += b.poses[a + k] * b.poses[c + k];
  for (let k = 0; k < 7; k++) { const to = k > 2 && same < 0 ? -b.poses[c + k] : b.poses[c + k]; p.push(b.poses[a + k] + f * (to - b.poses[a + k])); }
  return p;
}
function scene() {
  const [i, f] = place(now), j = Math.min(i + 1, N - 1), bodies = [], lines = [];
  for (const b of D.bodies) {
    const p = pose_of(b, i, j, f);
    if (p.every(isFinite)) bodies.push({ ...b, at: p, turn: turn_of(p.slice(3)) });
  }
  for (const l of D.lines) {
    const point = m => { const a = 3 * (i * l.n + m), c = 3 * (j * l.n + m); return [0, 1, 2].map(q => l.points[a + q] + f * (l.points[c + q] - l.points[a + q])); };
    const points = Array.from({ length: l.n }, (_, m) => point(m)); if (!points.every(p => p.every(isFinite))) continue;
    lines.push({ l: l.l, points: l.turns ? coil(points[0], points[1], l.radius, l.turns) : points });
  }
  render(bodies, lines, D.captions.map(c => ({ words: c.words, at: [...c.at.subarray(3 * i, 3 * i + 3)] })), D.traces.map(t => t.at.subarray(0, 3 * i + 3)), playing);
}
begin();
