"""What notebooks show of analyses."""

from collections.abc import Callable
from dataclasses import replace
from xml.etree import ElementTree

import lagrangia as lag


def test_notebooks_show_tables(scene: Callable[[str], lag.Model]) -> None:
    """Names as text, numbers by their units: of equilibria with reactions, of modes with damping and shapes."""
    model = scene("model A Revolute h(a = world); Bar bar(m = 1, L = 1, a = h.b);\n"
                  "TorsionDamper d(c = 0.1, a = world, b = h.b); end A;")
    found, modes = model.equilibrium(starts=20), model.modes()
    for shown, count in ((found, 1 + len(found)), (modes, 3)):
        page = ElementTree.fromstring(f"<body>{shown._repr_html_()}</body>")
        assert len(page.findall("table")) == count
    first = ElementTree.fromstring(f"<body>{found._repr_html_()}</body>").find("table")
    assert first is not None
    rows = [[cell.text for cell in row] for row in first.iter("tr")]
    assert rows[0] == [None, "stability", "h.phi [rad]", "V [J]"]
    assert rows[1] == ["1", "asymptotically stable", f"{found[0].position['h.phi']:.6g}", f"{found[0].potential:.6g}"]
    text = modes._repr_html_()
    assert f"<td>{modes[0].frequency:.6g}</td>" in text and f"<td>{modes.damped[0].damping_ratio:.6g}</td>" in text
    assert "<b>" not in replace(modes, name="<b>")._repr_html_() and "&lt;b&gt;" in replace(modes, name="<b>")._repr_html_()
