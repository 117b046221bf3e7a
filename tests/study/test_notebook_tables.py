"""What notebooks show of analyses."""

from collections.abc import Callable
from dataclasses import replace
from xml.etree import ElementTree

import lagrangia as lag
from lagrangia.study.text import equilibria_text


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


def test_forces_of_equations_stand_apart_from_those_of_joints(scene: Callable[[str], lag.Model]) -> None:
    """Without a joint, rest of a driven body ended in a RuntimeError; beside one, its force stood in the column F_x, at a port"""
    driven = "PointMass P(m=2); Motion drive(of = P.center.x, to = 0.2); output Force f = constraint_force(P.center.y);"
    alone = scene(f"model A {driven} equation P.center.y = 0.4; end A;").equilibrium()
    assert alone[0].reactions == {"f": 2 * 9.81, "drive.reaction": 0.0} and not alone.reactions_on(alone[0])
    told = equilibria_text(alone)
    assert "  f              = 19.62 N\n  drive.reaction = 0" in told and "reactions on" not in told
    both = scene(f"model B Revolute h(a = world); Bar bar(m = 1, L = 1, a = h.b); {driven}\n"
                 "equation P.center.y = 0.4; end B;").equilibrium()
    assert [*both.reactions_on(both[0])] == ["h.b"] and both.forces_along(both[0])["f"] == 2 * 9.81
    assert "<th>f [N]</th>" in both._repr_html_()
