// Names beside what they name: never on each other, and on no line where one of many places about theirs is free.
const font = p => (p[1] ? "italic " : "") + (p[2] ? 11 : 15) + "px 'STIX Two Text','Times New Roman',serif";
const width_of = (g, pieces) => pieces.width ??= pieces.reduce((w, p) => { g.font = font(p); return w + g.measureText(p[0]).width; }, 0);
function words(g, pieces, x, y, width) {  // from x on, about y; squeezed where they are wider than that
  g.save(); g.translate(x, y); g.scale(Math.min(1, width / pieces.width), 1); x = y = 0;
  g.strokeStyle = css.bg; g.lineWidth = 3; g.lineJoin = "round";  // lines do not run through words
  let from = x; for (const p of pieces) { g.font = font(p); g.strokeText(p[0], from, y + 5 + (p[2] ? 4 : 0)); from += g.measureText(p[0]).width; }
  for (const p of pieces) { g.font = font(p); g.fillText(p[0], x, y + 5 + (p[2] ? 4 : 0)); x += g.measureText(p[0]).width; }
  g.restore();
}
// A pen on a canvas that knows where its lines ran, in cells of so many pixels; without a grid it only draws.
const CELL = 4, MOST_CELLS = 4000;  // of a line
let cells = new Uint8Array(0), sums = new Uint32Array(0);
class Pen {
  constructor(g, w, h, has_grid) {
    this.g = g; this.m = has_grid ? Math.ceil(w / CELL) : 0; this.n = has_grid ? Math.ceil(h / CELL) : 0;
    if (cells.length !== this.m * this.n) { cells = new Uint8Array(this.m * this.n); sums = new Uint32Array((this.m + 1) * (this.n + 1)); } else cells.fill(0);
  }
  begin() { this.g.beginPath(); this.first = this.last = null; }
  to(x, y) {
    if (this.last) { this.g.lineTo(x, y); this.mark(...this.last, x, y); } else { this.g.moveTo(x, y); this.first = [x, y]; }
    this.last = [x, y];
  }
  close() { if (this.first) { this.g.closePath(); this.mark(...this.last, ...this.first); } }
  round(x, y, r) {
    this.g.arc(x, y, r, 0, 7);
    const count = Math.max(6, Math.min(200, Math.ceil(6.3 * r / CELL)));
    for (let i = 0; i < count; i++) { const [a, b] = [i, i + 1].map(k => 6.2832 * k / count); this.mark(x + r * Math.cos(a), y + r * Math.sin(a), x + r * Math.cos(b), y + r * Math.sin(b)); }
  }
  mark(ax, ay, bx, by) {
    if (!this.m) return;
    const count = Math.min(MOST_CELLS, Math.ceil(Math.max(Math.abs(bx - ax), Math.abs(by - ay)) / CELL) || 1);
    for (let i = 0; i <= count; i++) {
      const x = Math.floor((ax + (bx - ax) * i / count) / CELL), y = Math.floor((ay + (by - ay) * i / count) / CELL);
      if (x >= 0 && x < this.m && y >= 0 && y < this.n) cells[y * this.m + x] = 1;
    }
  }
  add() {  // sums[i, j]: of all cells to the left of i and above j
    const m = this.m, w = m + 1;
    for (let j = 0; j < this.n; j++) for (let i = 0, row = 0; i < m; i++) { row += cells[j * m + i]; sums[(j + 1) * w + i + 1] = sums[j * w + i + 1] + row; }
  }
  under([left, top, right, bottom]) {  // how many cells of a box a line runs through
    const at = (x, most) => Math.max(0, Math.min(most, x)), w = this.m + 1;
    const a = at(Math.floor(left / CELL), this.m), b = at(Math.ceil(right / CELL), this.m), c = at(Math.floor(top / CELL), this.n), d = at(Math.ceil(bottom / CELL), this.n);
    return sums[d * w + b] - sums[c * w + b] - sums[d * w + a] + sums[c * w + a];
  }
}
// Places about a spot, the best first: how far from it, and how far turned from the side where a name belongs.
const PLACES = [3, 7, 12, 19, 28, 40, 56, 80].flatMap((reach, i) => [0, 1, -1, 2, -2, 3, -3, 4, -4, 5, -5, 6, -6, 7, -7, 8].map(k => {
  const angle = k * Math.PI / 8; return { reach, c: Math.cos(angle), s: Math.sin(angle), cost: 1.2 * i + 0.5 * Math.abs(angle) };
})).sort((a, b) => a.cost - b.cost), NEAR = 12, FAR = 56, FEW = 20, INK = 6;  // what a cell of a line costs
const HELD = 800, LATER = 1500, ROW = 32, GAP = 5, chosen = [];  // ms: as long as a name stays on a line that passes, and stays far from its spot
class Crowd {  // boxes that are taken, by rows
  constructor() { this.rows = new Map(); }
  *rows_of(box) { for (let k = Math.floor(box[1] / ROW); k <= Math.floor(box[3] / ROW); k++) yield k; }
  is_free(b) { for (const k of this.rows_of(b)) for (const o of this.rows.get(k) || []) if (b[0] < o[2] + GAP && b[2] + GAP > o[0] && b[1] < o[3] && b[3] > o[1]) return false; return true; }
  take(b) { for (const k of this.rows_of(b)) { if (!this.rows.has(k)) this.rows.set(k, []); this.rows.get(k).push(b); } }
}
function box_of(c, place, w, width, height) {
  const [a, b] = c.u || c.v ? [c.u, c.v] : [0, 1], u = a * place.c - b * place.s, v = a * place.s + b * place.c;
  const away = place.reach && Math.abs(u) * w / 2 + Math.abs(v) * 8 + place.reach;  // as far as its box reaches in that direction, and on
  const clip = (x, most) => Math.max(2, Math.min(x, most)), x = clip(c.x + u * away - w / 2, width - w - 2), y = clip(c.y - v * away - 8, height - 19);
  return [x, y, x + w, y + 17];
}
// Captions { words, x, y, u, v }: beside their places towards (u, v), or about them. They stay where they are while it is free.
function captions(pen, all, is_moving) {
  const g = pen.g, width = g.canvas.clientWidth, height = g.canvas.clientHeight, crowd = new Crowd(), ms = performance.now(), shown = [];
  const about = { reach: 0, c: 1, s: 0, cost: -1 }, waiting = [];
  const put = (i, place, box) => { if (chosen[i]?.place !== place) chosen[i] = { place, since: ms }; crowd.take(box); shown.push([all[i].words, box]); };
  pen.add();
  all.forEach((c, i) => {
    if (!c) { chosen[i] = undefined; return; }
    const own = chosen[i], w = Math.min(width_of(g, c.words), width - 4), box = own && box_of(c, own.place, w, width, height);
    const stays = own && (is_moving && ms - own.since < HELD || !pen.under(box) && (own.place.reach <= NEAR || ms - own.since < LATER));
    if (stays && crowd.is_free(box)) put(i, own.place, box); else waiting.push([i, w]);
  });
  for (const [i, w] of waiting) {
    const c = all[i], own = chosen[i]?.place;
    let best = null, least = Infinity, found = null;
    for (const place of c.u || c.v ? PLACES : [about, ...PLACES]) {
      if (place.cost >= least) break;
      if (place.reach > FAR && (c.u || c.v) && all.length > FEW) continue;  // among many, a name far away seems to be another's
      const box = box_of(c, place, w, width, height), room = [box[0] - 8, box[1] - 8, box[2] + 8, box[3] + 8];  // where it stays free longer
      const cost = place.cost + INK * pen.under(box) + 0.1 * Math.min(10, pen.under(room)) + (crowd.is_free(room) ? 0 : 1) - (place === own ? 0.5 : 0);
      if (cost < least && crowd.is_free(box)) { best = place; least = cost; found = box; }
    }
    if (best) put(i, best, found); else chosen[i] = undefined;
  }
  g.fillStyle = css.fg;
  for (const [pieces, box] of shown) words(g, pieces, box[0], box[1] + 8, box[2] - box[0]);
}
