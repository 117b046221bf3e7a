"""Scenes as textbooks draw them: what stands in the picture, where, and by which name."""

import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.base.folders import data_folder
from lagrangia.command.cli import WRONG, main
from lagrangia.draw.drawing import page_of
from lagrangia.draw.film import reel_of
from lagrangia.draw.page import FONT, Page
from lagrangia.draw.strokes import SHAPES, Given
from lagrangia.draw.tikz import write_tikz
from lagrangia.language.figures import OF_SPACE, WORDS
from lagrangia.run.request import Request
from lagrangia.solids.seen import SHOWN

EXAMPLES = data_folder("models") / "examples"
TEXTBOOK = ("suspended_bar", "disc_and_block", "disc_and_block_damped")
ALL = sorted(path.stem for path in EXAMPLES.glob("*.lag"))
_SVG = "{http://www.w3.org/2000/svg}"


def texts(svg: str) -> list[str]:
    return ["".join(text.itertext()) for text in ElementTree.fromstring(svg).iter(f"{_SVG}text")]


def page(name: str) -> Page:
    return page_of(lag.load(EXAMPLES / f"{name}.lag"), Request(), {})[0]


def boxes(page: Page) -> list[tuple[str, np.ndarray, np.ndarray]]:
    found = []
    for label in page.labels:
        half = np.array([label.words.width / 2, FONT * 0.4])
        found.append((label.words.plain, np.array(label.at) - half, np.array(label.at) + half))
    return found


def crossings(page: Page, low: np.ndarray, high: np.ndarray) -> int:
    """How many lines of the page go through a box."""
    count = 0
    for path in page.paths:
        for a, b in zip(path.points, path.points[1:], strict=False):
            line = a + np.linspace(0, 1, 50)[:, None] * (b - a)
            count += bool(np.any(np.all((line > low) & (line < high), axis=1)))
    return count


def test_every_word_has_its_shape() -> None:
    assert SHAPES.keys() == WORDS.keys() - {"trace"} - OF_SPACE, "a trace is made of many moments"
    assert WORDS.keys() - {"trace", "text", "gears", "belt"} == SHOWN.keys()


@pytest.mark.parametrize(("name", "expected"), [
    ("suspended_bar", {"k1", "k2", "c1", "c2", "m, L", "P(t)", "s", "φ"}),
    ("disc_and_block", {"k1", "k2", "m", "md, r", "M(t)", "s", "φ"}),
    ("disc_and_block_damped", {"k1", "k2", "c1", "c2", "m", "md, r", "M(t)", "s", "φ"}),
])
def test_the_textbook_scenes_name_what_they_are_made_of(name: str, expected: set[str]) -> None:
    drawn = page(name)
    assert {label.words.plain for label in drawn.labels} == expected
    found = boxes(drawn)
    for k, (one, low, high) in enumerate(found):
        assert crossings(drawn, low, high) == 0, one
        assert not [other for other, a, b in found[k + 1 :] if np.all(low < b) and np.all(high > a)], one
    assert 60 < drawn.width < 95, "readable at 8 cm"


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in ALL if name not in TEXTBOOK])
def test_every_example_draws(name: str) -> None:
    svg = lag.load(EXAMPLES / f"{name}.lag").draw()
    root = ElementTree.fromstring(svg)
    width, height = (float(root.attrib[side].removesuffix("mm")) for side in ("width", "height"))
    shown = [x for shape in root.iter() if "points" in shape.attrib for x in shape.attrib["points"].split()]
    rounds = [[float(shape.attrib[x]) for x in ("cx", "cy", "r")] for shape in root.iter(f"{_SVG}circle")]
    points = np.array([[float(y) for y in x.split(",")] for x in shown]
                      + [[x + side * r, y + side * r] for x, y, r in rounds for side in (-1, 1)])
    assert points.min() >= -0.01 and np.all(points.max(axis=0) <= np.array([width, height]) + 0.01), "nothing is cut"
    assert len(texts(svg)) >= 1


def test_names_and_times_are_chosen() -> None:
    model = lag.load(EXAMPLES / "pendulum.lag")
    assert set(texts(model.draw(names={"hinge.phi": "theta"}))) == {"m", "θ"}
    assert model.draw(at=0.3) != model.draw()
    assert model.draw(parameters={"L": 2.0}) == model.draw(), "a picture is as large as its page"
    with pytest.raises(lag.LagError, match="L0711"):
        model.draw(names={"hinge.psi": "theta"})


MARKUP = """
model Marked "a < b & \\"c\\""
  Revolute hinge(a = world);
  Bar bar(m = 1, L = 1, a = hinge.b);
drawing
  text(shift(bar.b, {0.2, 0}), "<b>&</b>");
  polygon(bar.a, bar.b, bar.center.r + {0, 0.2}, fill = "grey");
  arc(bar.b, 0.1, 0, 90[deg]);
end Marked;
"""


def test_markup_in_texts_is_text(scene: Callable[[str], lag.Model]) -> None:
    svg = scene(MARKUP).draw()
    assert "<b>&</b>" in texts(svg)
    assert ElementTree.fromstring(svg).find(f"{_SVG}title").text == 'a < b & "c"'  # type: ignore[union-attr]


def spring(length: float, reference: float) -> np.ndarray:
    places = np.array([[0.0, 0.0, 0.0], [length, 0.0, 0.0]])
    return SHAPES["zigzag"](Given(places, [], 1.0, {}, "none", "normal", reference=reference)).strokes[0].points


def test_a_spring_keeps_its_wire() -> None:
    def wire(points: np.ndarray) -> float:
        return float(np.linalg.norm(np.diff(points[2:-2], axis=0), axis=1).sum())

    first = wire(spring(6.0, 6.0))
    assert [wire(spring(x, 6.0)) for x in (5.9, 5.0, 4.5)] == pytest.approx([first] * 3, rel=0.02)


SMALL = """
model Small
  Revolute hinge(a = world);
  PointMass bob(m = 1, center = shift(hinge.b, {{{length}, 0}}));
end Small;
"""


@pytest.mark.parametrize("length", ["1e-9", "1e9"])
def test_size_does_not_matter(length: str, scene: Callable[[str], lag.Model]) -> None:
    usual, other = (lag.Model.draw(scene(SMALL.format(length=x))) for x in ("1", length))
    assert re.sub(r"[\d.]+", "", other) == re.sub(r"[\d.]+", "", usual)


def test_one_point_is_a_picture(scene: Callable[[str], lag.Model]) -> None:
    svg = scene("model One PointMass m(m = 1); end One;").draw()
    assert texts(svg) == ["m"] and "<circle" in svg and "nan" not in svg


@pytest.mark.parametrize(("suffix", "head"), [(".svg", b"<svg"), (".png", b"\x89PNG"), (".pdf", b"%PDF"),
                                              (".tex", b"% ")])
def test_files(suffix: str, head: bytes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["draw", str(EXAMPLES / "pendulum.lag"), "-o", f"x{suffix}", "--at", "0.2"]) == 0
    assert Path(f"x{suffix}").read_bytes().startswith(head)


@pytest.mark.parametrize("name", ["suspended_bar", "quarter_car", "slider_crank"])
def test_tikz_for_latex(name: str, tmp_path: Path) -> None:
    """As many paths as the SVG has, all labels, and pdflatex reads it where it is installed."""
    page, _ = page_of(lag.load(EXAMPLES / f"{name}.lag"), Request(), {})
    text = write_tikz(page)
    assert text.count("\\draw") == len(page.paths) and text.count("\\node") == len(page.labels) > 2
    assert text.isascii() and text.count("{") == text.count("}")
    if shutil.which("pdflatex") is None or not subprocess.run(["kpsewhich", "tikz.sty"], capture_output=True, check=False).stdout:
        return
    (tmp_path / "page.tex").write_text(f"\\documentclass{{article}}\\usepackage{{amsmath,tikz}}\n\\begin{{document}}\n{text}"
                                       "\\end{document}\n", encoding="utf-8")
    command = ["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "page.tex"]
    run = subprocess.run(command, cwd=tmp_path, capture_output=True, check=False)
    assert run.returncode == 0, run.stdout.decode(errors="replace")[-1500:]


@pytest.mark.parametrize(("given", "code"), [
    (["-o", "x.csv"], "L0004"), (["--at", "soon"], "L0706"), (["--names", "a=b"], "L0711"),
    (["-p", "mass=2"], "L0701"),
])
def test_what_cannot_be_drawn_is_told(given: list[str], code: str, tmp_path: Path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["draw", str(EXAMPLES / "pendulum.lag"), *given]) == WRONG
    assert f"error[{code}]" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_runs_and_explanations_know_nothing_of_pictures(tmp_path: Path) -> None:
    program = "import sys; from lagrangia.command.cli import main; main(sys.argv[1:]); print(*sys.modules, sep='\\n')"
    for command in (["simulate", "-o", str(tmp_path / "x.csv")], ["explain"]):
        run = subprocess.run([sys.executable, "-c", program, command[0], str(EXAMPLES / "pendulum.lag"), *command[1:]],
                             capture_output=True, text=True, check=True)
        assert "lagrangia.draw" not in run.stdout.split()


def test_a_motion_that_ends_before_is_drawn_where_it_ended(scene: Callable[[str], lag.Model], tmp_path: Path) -> None:
    model = scene("model X Block b(m = 1, base = world, s(start = 1), v(start = 1)); GeneralSpring s(V = -1[N/m2]*b.s^3);\n"
                  "annotation(experiment(StopTime = 10)); end X;")
    with pytest.raises(lag.RunError, match=r"what was computed before is drawn in .*x\.svg"):
        model.draw(tmp_path / "x.svg", at=5)
    assert ElementTree.parse(tmp_path / "x.svg").getroot() is not None


def test_many_points_stay_apart(scene: Callable[[str], lag.Model]) -> None:
    """Symbols are no larger than there is room between them, and lines are lighter then."""
    page, _ = page_of(scene("model M parameter Integer n = 64; PointMass p[n](each m = 1);\ninitial equation for i in 1:n loop "
                            "p[i].center.x = mod(i, 8); p[i].center.y = floor(i/8); end for; end M;"), Request(), {})
    circles = [path for path in page.paths if path.radius > 0]
    assert len(circles) == 64
    centres = np.array([path.points[0] for path in circles])
    gaps = np.linalg.norm(centres[:, None] - centres[None], axis=2) + 1e9 * np.eye(64)
    assert gaps.min() > 2 * circles[0].radius


def test_loose_parts_keep_clear_of_each_other_all_the_time() -> None:
    """Masses of an absorber, whose places nothing but numbers say: the spring between them is as long as they need."""
    model = lag.load(EXAMPLES / "vibration_absorber.lag")
    reel = reel_of(model.simulate(stop=6, interval=0.05), {}, [])
    boxes = [moving for moving in reel.strokes if moving.stroke.fill == "white" and moving.poses is not None]
    machine, absorber = (box.poses[:, 0] for box in boxes)
    half = np.ptp(boxes[0].stroke.points[:, 0])
    assert (absorber - machine).min() > half


CASES = Path(__file__).parents[1] / "cases"


def test_a_scene_with_a_trace_is_drawn() -> None:
    assert lag.load(CASES / "constraint_library.lag", model="BeadOnParabola").draw().count("<circle") >= 1


def test_walls_stand_where_no_other_part_is() -> None:
    """Wall, mass, mass, wall: each spring to the ground is on the free side of its mass."""
    page, _ = page_of(lag.load(CASES / "linear_2dof_vibration.lag", model="TwoMasses"), Request(), {})
    bodies = sorted(float(path.points[:, 0].mean()) for path in page.paths if path.fill == "white" and len(path.points) == 4)
    lines = [path.points for path in page.paths if len(path.points) == 2 and path.line == "normal"]
    walls = {float(x[0, 0]) for x in lines if np.ptp(x[:, 0]) < 1e-6 and np.ptp(x[:, 1]) > 5}
    assert len(bodies) == 2 and min(walls) < bodies[0] and max(walls) > bodies[1]
    assert not any(bodies[0] < x < bodies[1] for x in walls)


def test_a_scene_without_drawings_says_so(tmp_path: Path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["draw", str(CASES / "classroom" / "bead_on_hoop.lag"), "-o", "x.svg"]) == 0
    assert "nothing in this scene has a drawing" in capsys.readouterr().err


def test_letters_of_formulas_are_letters_in_pictures() -> None:
    """As wide with dollars as the same letters without a meaning, whether one or two of them stand there."""
    from lagrangia.draw.page import Label, Page, Words
    from lagrangia.draw.paint import paint_page

    def width(text: str) -> float:
        page = Page(80.0, 20.0, (), (Label(Words(((text, False, False),)), (40.0, 10.0)),))
        (patch,) = paint_page(page).axes[0].patches
        box = patch.get_path().get_extents()
        return float(box.x1 - box.x0)

    assert width("$x^2$") == pytest.approx(width("$x^2") + width("$|") - width("|"), rel=0.1)
    assert width(r"a\b") > width("ab")


def test_what_acts_late_is_drawn_beside_an_input(scene: Callable[[str], lag.Model]) -> None:
    """Also in the icons of FMUs: values of the past, which come behind the inputs, are in no row of results."""
    model = scene("model A input Force u(start = 1); Block b(m = 1, base = world); "
                  "AppliedForce f(at = b.center, force = {F, 0}); Force F = delay(u, 0.2) + delay(b.s, 0.1)*2[N/m]; end A;")
    assert "<svg" in model.draw(at=0.5)
