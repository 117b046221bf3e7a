// A scene in space, as it is now.
for (const form of Object.values(D.forms)) form.v = new Float32Array(bytes(form.v));
const point_of = k => [rows[k], rows[k + 1], rows[k + 2]], WIDTH = 3;
function scene() {
  const { bodies, lines, names } = moment(D, rows);
  render(bodies.map(b => ({ ...D.forms[b.form], ...b })), lines, names, traces, running);
}
$("scene").setAttribute("aria-label", "the mechanism in motion; it is turned, shifted and zoomed by hand");
