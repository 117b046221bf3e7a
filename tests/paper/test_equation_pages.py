"""`lag equations`: every form in every format, names, numbers, limits, wrong input, and the page in a browser."""

import json
import math
import os
import re
import shutil
import subprocess
import sys
import time
from html.parser import HTMLParser
from pathlib import Path

import pytest
import sympy as sp

import lagrangia as lag
from helpers.derived_once import derive_once, once
from helpers.printed_numbers import everything_laid_out
from helpers.symbolic_scenes import CLASSROOM, EXAMPLES, UNWRITTEN, WRITTEN
from lagrangia.command.cli import WRONG, main
from lagrangia.paper import sheet
from lagrangia.paper.layout import Bracket, Name, Numeral, Product, Relation, Total, broken
from lagrangia.paper.notation import Wanted, name_all
from lagrangia.paper.sheet import ALL_FORMATS, ALL_FORMS
from lagrangia.paper.typeset import line

GOLDEN = Path(__file__).parents[1] / "golden" / "equations"
ALL = WRITTEN
LARGE = ("chain", "scissor_lift")
SLOW = ("scissor_lift", "andrews_squeezer", "pantograph", "n_four_bars")
LOSING = ("cart_pole", "disc_and_block_damped", "gear_train", "quarter_car", "stick_slip", "suspended_bar", "torsion_rotor",
          "vibration_absorber")  # not conservative
RESTLESS = ("atwood", "bouncing_ball", "free_bar", "gear_train", "skate", "slider_crank")  # nothing balances what drives them


def equations(capsys, name: str, *options: str) -> str:
    assert main(["equations", str(EXAMPLES / f"{name}.lag"), *options]) == 0
    told = capsys.readouterr()
    assert told.err == ""
    return told.out


def refused(capsys, *arguments: str) -> str:
    assert main(["equations", *arguments]) == WRONG
    told = capsys.readouterr()
    assert told.out == ""
    assert "Traceback" not in told.err
    return told.err


# ---------------------------------------------------------------- texts kept, to be read


@pytest.mark.parametrize(("name", "code"), UNWRITTEN.items())
def test_what_has_no_written_equations_is_told(name: str, code: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert f"error[{code}]" in refused(capsys, str(EXAMPLES / f"{name}.lag"))


@pytest.mark.parametrize("name", ["suspended_bar", "disc_and_block_damped", "double_pendulum", "slider_crank", "crank_press",
                                  "skate", "quarter_car", "spring_pendulum"])
def test_worked(name: str, capsys, compare) -> None:
    compare(equations(capsys, name, "--form", "worked"), GOLDEN / f"{name}.worked.txt")


@pytest.mark.parametrize("path", sorted(CLASSROOM.glob("*.lag")), ids=lambda path: path.stem)
def test_derivations_of_the_classroom(path: Path, capsys, compare) -> None:
    """Each read line by line, as a teacher reads it."""
    assert main(["equations", str(path), "--form", "worked"]) == 0
    compare(capsys.readouterr().out, GOLDEN / "classroom" / f"{path.stem}.txt")


@pytest.mark.parametrize("form", [form for form in ALL_FORMS if form not in ("worked", "conservative")])
def test_forms_of_the_suspended_bar(form: str, capsys, compare) -> None:
    compare(equations(capsys, "suspended_bar", "--form", form), GOLDEN / f"suspended_bar.{form}.txt")


@pytest.mark.parametrize("format", ["markdown", "latex", "html", "sympy"])
def test_formats_of_the_suspended_bar(format: str, capsys, compare) -> None:
    compare(equations(capsys, "suspended_bar", "--format", format), GOLDEN / f"suspended_bar.{format}.txt")


@pytest.mark.parametrize(("ending", "format"), [(".md", "markdown"), (".TEX", "latex"), (".html", "html"), (".py", "sympy"),
                                               (".x", "text")])
def test_files_are_of_the_format_they_end_in(ending: str, format: str, tmp_path: Path, capsys) -> None:
    """Unless another one is asked for: page.html held plain text, without a word."""
    asked = ["equations", str(EXAMPLES / "pendulum.lag")]
    for given, expected in (([], format), (["--format", "markdown"], "markdown")):
        file = tmp_path / f"page{ending}"
        assert main([*asked, "-o", str(file), *given]) == 0
        capsys.readouterr()
        assert main([*asked, "--format", expected]) == 0
        assert file.read_text() == capsys.readouterr().out


def test_a_chain_of_five_fits_on_two_pages_and_its_derivation_does_not(capsys, compare) -> None:
    compare(equations(capsys, "chain", "--form", "worked"), GOLDEN / "chain.txt")
    said = equations(capsys, "chain")
    assert "φ₅''" in said and len(said.splitlines()) < 180 and max(map(len, said.splitlines())) <= 110
    assert "terms" in equations(capsys, "scissor_lift")


def test_small_motion_of_what_is_too_large_to_read(capsys) -> None:
    """Seven coordinates and six constraints in numbers, and one equation that is left; no 1e-16, no 1 x."""
    said = equations(capsys, "scissor_lift", "--form", "linear")
    assert "16.9569 Δφ_cross1'' + 306.345 Δφ_cross1 = 0" in said
    assert "·10⁻" not in said and "= 1 Δ" not in said and "Δφ_cross2 = Δφ_cross1" in said


# ---------------------------------------------------------------- every example


@pytest.mark.parametrize("path", [
    pytest.param(path, id=path.stem, marks=pytest.mark.slow if path.stem in SLOW else ()) for path in ALL
])
def test_every_form_of_every_example(path: Path, capsys, monkeypatch) -> None:
    monkeypatch.setattr(sheet, "_too_large", once(sheet._too_large))  # the energies' structure, whatever the form
    derive_once(monkeypatch)
    for form in ALL_FORMS:
        if form == "linear" and path.stem in RESTLESS:
            assert "L0713" in refused(capsys, str(path), "--form", form)
            continue
        if form == "conservative" and path.stem in LOSING:
            assert "not conservative" in refused(capsys, str(path), "--form", form)
            continue
        said = equations(capsys, path.stem, "--form", form, *(["-p", "n=3"] if path.stem == "chain" else []))
        assert not re.search(r"Derivative|Symbol|Rational|\bNone\b|Float|\*\*|der\(", said)
        assert said.startswith(path.stem.replace("_", "").lower()[:3].capitalize()) or said[0].isupper()
        assert [row for row in said.splitlines() if len(row) > 100] == []


@pytest.mark.parametrize("path", [path for path in ALL if path.stem not in LARGE], ids=lambda path: path.stem)
def test_pages_are_well_formed(path: Path, capsys, monkeypatch) -> None:
    """HTML, which stands alone, and LaTeX, of one derivation."""
    for made in ("_book", "_form"):
        monkeypatch.setattr(sheet, made, once(getattr(sheet, made)))
    page = equations(capsys, path.stem, "--form", "worked", "--format", "html")
    checker = Balanced()
    checker.feed(page)
    assert checker.open == []
    assert "<math" in page and "<figure><svg" in page
    assert not re.search(r"<script|<link|src=|href=|url\(|@import|http", page)
    page = equations(capsys, path.stem, "--form", "worked", "--format", "latex")
    plain = page.replace(r"\{", "").replace(r"\}", "")
    assert plain.count("{") == plain.count("}")
    assert page.count(r"\left") == page.count(r"\right")
    assert page.count(r"\begin{") == page.count(r"\end{")
    assert page.isascii()


class Balanced(HTMLParser):
    """Every element is closed in its turn."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []

    def handle_starttag(self, tag: str, attributes: object) -> None:
        if tag not in ("meta",):
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attributes: object) -> None:
        pass

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


@pytest.mark.skipif(shutil.which("pdflatex") is None, reason="there is no pdflatex")
@pytest.mark.parametrize("is_fragment", [False, True])
@pytest.mark.parametrize("name", ["slider_crank", "crank_press", "double_pendulum", "quarter_car"])
def test_latex_compiles_and_nothing_stands_in_the_margin(name: str, is_fragment: bool, tmp_path: Path, capsys) -> None:
    page = equations(capsys, name, "--form", "worked", "--format", "latex", *["--fragment"] * is_fragment)
    assert ("tikzpicture" in page) != is_fragment, "a fragment needs amsmath alone"
    if is_fragment:
        assert "documentclass" not in page and "usepackage" not in page and r"\label{lag:a}" in page
        page = (r"\documentclass[11pt]{article}\usepackage[margin=22mm,a4paper]{geometry}\usepackage{amsmath}\sloppy"
                f"\n\\begin{{document}}\n{page}\n\\end{{document}}\n")
    (tmp_path / "page.tex").write_text(page, encoding="utf-8")
    command = ["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "page.tex"]
    run = subprocess.run(command, cwd=tmp_path, capture_output=True, check=False)
    assert run.returncode == 0, run.stdout.decode(errors="replace")[-2000:]
    assert b"Overfull" not in run.stdout


# ---------------------------------------------------------------- in a browser

BROWSER = next((found for name in ("chromium", "chromium-browser", "google-chrome") if (found := shutil.which(name))), None)


@pytest.mark.skipif(BROWSER is None, reason="there is no Chromium")
@pytest.mark.parametrize("name", ["suspended_bar", "crank_press"])
def test_the_worked_page_in_a_browser(name: str, tmp_path: Path, capsys) -> None:
    """Its layout is what was meant: fractions are stacked, nothing is cut off at the width of A4, and it prints on pages."""
    page = equations(capsys, name, "--form", "worked", "--format", "html")
    probe = """<script>
      const box = e => e.getBoundingClientRect(), all = s => [...document.querySelectorAll(s)];
      const stacked = all('mfrac').every(f => box(f.children[0]).bottom <= box(f.children[1]).top + 1);
      const wide = all('math').filter(m => box(m).right > innerWidth || box(m).width === 0).length;
      document.body.style.width = '170mm';
      document.body.style.padding = 0;
      document.body.style.fontSize = '11pt';
      const size = e => [e.scrollWidth, e.clientWidth, e.scrollHeight, e.clientHeight];
      const cut = all('.shown').map(size).filter(([w, room, h, height]) => w > room + 1 || h > height + 1);
      const high = all('msup').every(s => box(s.children[1]).top < box(s.children[0]).bottom);
      document.title = JSON.stringify({maths: all('math').length, fractions: all('mfrac').length, stacked, wide, high, cut});
    </script></body>"""
    (tmp_path / "page.html").write_text(page.replace("</body>", probe), encoding="utf-8")
    command = [str(BROWSER), "--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={tmp_path / 'profile'}",
               "--window-size=1000,1400"]
    address = (tmp_path / "page.html").as_uri()
    run = subprocess.run([*command, "--dump-dom", address], capture_output=True, text=True, timeout=120, check=True)
    title = re.search(r"<title>(.*?)</title>", run.stdout)
    assert title is not None
    found = json.loads(title[1])
    assert found["maths"] > 40
    assert found["fractions"] > 30
    assert (found["stacked"], found["high"], found["wide"], found["cut"]) == (True, True, 0, [])
    printed = tmp_path / "page.pdf"
    subprocess.run([*command, f"--print-to-pdf={printed}", address], capture_output=True, timeout=120, check=True)
    assert printed.stat().st_size > 10_000
    assert printed.read_bytes().startswith(b"%PDF")


# ---------------------------------------------------------------- names, numbers


def test_names_of_ones_own(capsys) -> None:
    said = equations(capsys, "suspended_bar", "--names", "tilt.phi=theta,guide.s=x")
    assert "m x'' + (c₁ + c₂) x' + ½ (c₂ − c₁) L θ' cos θ + (k₁ + k₂) x + ½ (k₂ − k₁) L sin θ = P(t)" in said
    assert "x is guide.s, θ is tilt.phi." in said


def test_names_as_people_write_them(capsys) -> None:
    chosen = r"tilt.phi=\theta_1,guide.s=x_{cm},D=σ,W=tau"
    said = equations(capsys, "suspended_bar", "--form", "worked", "--names", chosen)
    assert "σ = ½ c₁ (x_cm' − ½ L θ₁' cos θ₁)² + ½ c₂ (x_cm' + ½ L θ₁' cos θ₁)²" in said
    assert "δτ_f = P(t) δ(x_cm + (a − ½ L) sin θ₁)" in said
    assert "D" not in re.sub(r"[A-Z]\w*\b(?<!D)|d'Alembert's", "", said).replace("Data", "")
    path = str(EXAMPLES / "suspended_bar.lag")
    for names in ("tilt.phi=θ,guide.s=theta", "D=θ,tilt.phi=theta", "D=T", "D=sigma,T=σ", "D=1"):
        assert "L0711" in refused(capsys, path, "--names", names)


def test_short_names_where_they_are_unambiguous() -> None:
    def named(*sources: str) -> list[str]:
        found = name_all([Wanted(source) for source in sources], {})
        return [line(found[source]) for source in sources]

    assert named("guide.s", "tilt.phi", "bar.I", "m") == ["s", "φ", "I", "m"]
    assert named("O.phi", "pin.phi") == ["φ_O", "φ_pin"]
    assert named("hinge[1].phi", "hinge[2].phi") == ["φ₁", "φ₂"]
    assert named("hinge[1].phi", "other.phi") == ["φ_hinge1", "φ_other"]
    assert named("k1", "ks", "md", "speed", "Omega", "s_rel0") == ["k₁", "k_s", "m_d", "speed", "Ω", "s_rel0"]
    assert named("m", "bob.m") == ["m", "m_bob"]
    assert named("rod.center.x", "rod.center.phi") == ["x", "φ"]
    assert named("k1", "k_1", "k2") == ["k1", "k_1", "k₂"]
    assert line(name_all([Wanted("t")], {}, [Name("t")])["t"]) == "t₁"
    assert named("left.arm.phi", "right.arm.phi") == ["φ_left,arm", "φ_right,arm"]
    loads = name_all([Wanted("P.force", True, True), Wanted("drive.torque", True), Wanted("push.force", True)], {})
    assert [line(x) for x in loads.values()] == ["P(t)", "M", "F"]


def test_numbers(capsys) -> None:
    said = equations(capsys, "suspended_bar", "--numbers", "-p", "m=4", "-p", "k1=2[kN/m]")
    assert "4 s'' + 40 s' + 3500 s − 500 sin φ = P(t)" in said
    assert "1.33333 φ''" in said  # I follows m


def test_a_structural_parameter(capsys) -> None:
    assert "φ₂" in equations(capsys, "chain", "-p", "n=2")
    assert "link[3]" not in equations(capsys, "chain", "-p", "n=2")


def test_linear_about_a_point(capsys) -> None:
    said = equations(capsys, "pendulum", "--form", "linear", "--about", "hinge.phi=60[deg]")
    assert "no equilibrium" in said
    assert "m L² Δφ'' + ½ m g L Δφ = − ½ √3 m g L" in said
    assert "φ₀ = − ½ π" in equations(capsys, "double_pendulum", "--form", "linear").replace("φ_shoulder,0", "φ₀")


@pytest.mark.slow
def test_force_writes_everything_and_ends(capsys, monkeypatch) -> None:
    said = equations(capsys, "chain", "-p", "n=6", "--force", "--form", "matrix")
    assert "M₆₆" in said and "too many" not in said
    monkeypatch.setattr("lagrangia.paper.sheet.MOST_FORCED_PRODUCTS", 3000)
    assert "L0712" in refused(capsys, str(EXAMPLES / "chain.lag"), "-p", "n=6", "--force")


# ---------------------------------------------------------------- limits and wrong input


@pytest.mark.parametrize(("options", "code"), [
    (["--form", "matrx"], "L0704"), (["--format", "pdf"], "L0704"), (["--names", "tilt.phi"], "L0706"),
    (["--names", "tilt.fi=theta"], "L0711"), (["--names", "tilt.phi=2x"], "L0711"),
    (["--names", "tilt.phi=x,guide.s=x"], "L0711"),
    (["--names", "tilt.phi=m"], "L0711"), (["--names", "tilt.phi=t"], "L0711"), (["--names", "m=x1,k1=x_1"], "L0711"),
    (["--names", "tilt.phi=a,tilt.phi=b"], "L0712"), (["-p", "mass=3"], "L0702"),
    (["-p", "m=heavy"], "L0706"), (["-p", "m=3[s]"], "L0706"), (["-p", "m"], "L0706"),
    (["--form", "linear", "--about", "bar=1"], "L0706"), (["--form", "linear", "--about", "tilt.phi=up"], "L0706"),
    (["--model", "Nothing"], "L0003"), (["--format", "sympy", "--form", "exercise"], "L0704"), (["-p", "m=nan"], "L0706"),
])
def test_wrong_options(options: list[str], code: str, capsys) -> None:
    assert f"error[{code}]" in refused(capsys, str(EXAMPLES / "suspended_bar.lag"), *options)


def test_what_is_no_number_is_refused() -> None:
    for value in (math.nan, -math.inf, True, None):
        with pytest.raises(lag.LagError, match="parameter 'm'"):
            lag.load(EXAMPLES / "suspended_bar.lag").equations(parameters={"m": value})


def test_a_scene_with_too_many_coordinates(capsys) -> None:
    chain = str(EXAMPLES / "chain.lag")
    begin = time.perf_counter()
    assert "L0712" in refused(capsys, chain, "-p", "n=200")
    assert "L0712" in refused(capsys, chain, "-p", "n=200", "--force")
    assert time.perf_counter() - begin < 30
    assert "too many to read" in equations(capsys, "chain", "-p", "n=24").replace("\n", " ")
    assert "L0712" in refused(capsys, chain, "-p", "n=7", "--format", "sympy")


def test_scenes_without_motion_and_files_without_scene(tmp_path: Path, capsys) -> None:
    (tmp_path / "still.lag").write_text("model Still\n  PointMass m(m = 1, center = world);\nend Still;\n", encoding="utf-8")
    assert "L0505" in refused(capsys, str(tmp_path / "still.lag"))
    assert "L0001" in refused(capsys, str(tmp_path / "nowhere.lag"))
    (tmp_path / "wrong.lag").write_text("model Wrong\n  Sprong s;\nend Wrong;\n", encoding="utf-8")
    assert "error[L02" in refused(capsys, str(tmp_path / "wrong.lag"))


REFUSED = {"linear": "L0912|L0713", "conservative": "not conservative"}  # forms that a scene may not have
ODD = {
    "an input": "input Force u; Block b(m = 1, base = world); AppliedForce F(at = b.center, force = {u, 0});",
    "a thruster": "Body b(m = 1, I = 2); BodyForce F(at = b.center, force = {1, 2*time});",
    "a table": "Block b(m = 1, base = world); AppliedForce F(at = b.center, force = {table(time, {0, 1, 2}, {0, 5, 1}), 0});",
    "a saturation": "Block b(m = 1, base = world); AppliedForce F(at = b.center, force = {-max(min(9*b.s, 3), -3), 0});",
    "absolute values": "Block b(m = 1, base = world); QuadraticDamper d(c = 2, rate = b.v); Spring s(k = 3, stretch = abs(b.s));",
    "a condition": "Block b(m = 1, base = world); GeneralSpring s(V = if b.s < 0 then 0 else 5*b.s^2, stretch = b.s);",
    "exponents": "parameter Length l = 1; parameter Real n = 2.5; Block b(m = 1, base = world);"
                 "GeneralSpring s(V = (3*exp(b.s/l) + abs(b.s/l)^n)*1[J], stretch = b.s);",
    "a rope": "PointMass l(m = 1, center(x(start = -1), y(start = -1))), r(m = 2, center(x(start = 1), y(start = -1)));"
              "Rope rope(L = 4, a = l.center, b = r.center); equation connect(rope.pulley[1], shift(world, {0, 1}));",
    "a turning world": "Revolute h(a = turn(world, 0.5*time^2)); Bar b(m = 1, L = 1, a = h.b);",
    "gravity askew": "World world(gravity = {1, -9}); Revolute h(a = world); Bar b(m = 1, L = 1, a = h.b);",
    "names that clash": "parameter Mass phi = 1, M = 2, lambda = 3; Revolute q(a = world); Bar T(m = M, L = 1, a = q.b);"
                        "Revolute h(a = T.b); Body V(m = phi, I = lambda*1[m2], center = h.b);",
}


@pytest.mark.parametrize("what", ODD)
def test_odd_scenes_have_equations_too(what: str, tmp_path: Path, capsys) -> None:
    (tmp_path / "odd.lag").write_text(f"model Odd\n  {ODD[what]}\nend Odd;\n", encoding="utf-8")
    for form in ALL_FORMS:
        for format in {"lagrange": ("text", "html", "sympy"), "worked": ("text", "html")}.get(form, ("latex",)):
            code = main(["equations", str(tmp_path / "odd.lag"), "--form", form, "--format", format])
            told = capsys.readouterr()
            assert code == 0 or re.search(REFUSED.get(form, "nothing"), told.err), (form, format, told.err)


def test_a_file_for_the_page(tmp_path: Path, capsys) -> None:
    page = tmp_path / "page.html"
    assert equations(capsys, "pendulum", "--format", "html", "-o", str(page)) == f"written to {page}\n"
    assert page.read_text(encoding="utf-8").startswith("<!DOCTYPE html>")


@pytest.mark.parametrize("name", ["suspended_bar", "disc_and_block", "cart_pole", "double_pendulum"])
def test_small_scenes_are_quick_from_a_cold_start(name: str) -> None:
    """CPU seconds, start and imports included: below 2 s on a machine of its own, here with room for slow ones."""
    program = ("import sys, time; from lagrangia.command.cli import main; code = main(sys.argv[1:]);"
               "print(time.process_time(), file=sys.stderr); sys.exit(code)")
    command = [sys.executable, "-c", program, "equations", str(EXAMPLES / f"{name}.lag")]
    run = subprocess.run(command, capture_output=True, text=True, check=True, env=os.environ | {"OMP_NUM_THREADS": "1"})
    assert float(run.stderr.split()[-1]) < 6.0


def test_long_lines_are_broken_between_terms() -> None:
    terms = Total(tuple((1, Product((Name("k", str(i)), Name("x", str(i))))) for i in range(40)))
    lines = broken(Relation(terms, Numeral(sp.Integer(0))), lambda node: len(line(node)), 80)
    assert len(lines) > 3
    assert all(len(line(part)) <= 84 for part in lines)
    assert line(lines[1]).startswith("+ ")
    assert line(Bracket(terms)).startswith("(k₀ x₀ + k₁ x₁")


def test_every_format_is_there() -> None:
    assert set(ALL_FORMATS) == {"text", "markdown", "latex", "html", "sympy"}


# ---------------------------------------------------------------- what is printed, evaluated

SLANTED = {
    "a vibrating pivot": "Frame pivot = shift(world, {0, 0.02*cos(300*time)}); Revolute hinge(a = pivot, phi(start = 1));"
                         "PointMass bob(m = 1, center = shift(hinge.b, {0, -1}));",
    "two floating bodies": "Body a(m = 1, I = 0.1, center(x(start = 1))), b(m = 2, I = 0.3);"
                           "Spring s(k = 10, s_rel0 = 0.5, a = shift(a.center, {0.1, 0}), b = shift(b.center, {-0.2, 0}));",
    "angles from the vertical": "coordinate Angle phi(start = 1), alpha(start = 0.5); parameter Length L = 1, l = 0.5;"
                                "parameter Mass m = 1; Length x = L*sin(phi) + l*sin(alpha), y = -L*cos(phi) - l*cos(alpha);"
                                "energy kinetic m*(der(x)^2 + der(y)^2)/2; potential m*9.81*y;",
    "a bend by 60 degrees": "Revolute h(a = world); Bar b(m = 1, L = 1, a = turn(h.b, 60[deg])); Block c(m = 2, base = b.b);"
                            "Spring s(k = 3, a = shift(world, {1, 0}), b = c.center);",
    "a parameter called t": "parameter Length t = 0.5; parameter Real rho(unit = \"kg/m\") = 3; Block b(m = 0, base = world);"
                            "Spring s(k = 3, stretch = b.s); energy kinetic rho*t*b.v^2/2;",
    "an input called t": "input Force t(start = 2); Block b(m = 1, base = world);"
                         "AppliedForce F(at = b.center, force = {t*sin(3*time/1[s]), 0});",
    "names of multipliers": "parameter Mass lambda = 2, lambda_1 = 3; parameter Stiffness k1 = 1, k_1 = 2;"
                            "parameter Length ell = 2; Block b(m = lambda, base = world); Revolute h(a = world);"
                            "Bar c(m = lambda_1, L = ell, a = h.b); Spring s(k = k1, a = shift(b.center, {1, 2}), b = c.b);"
                            "Spring s2(k = k_1, a = shift(c.center, {1, 2}), b = b.center);"
                            "equation norm(c.b.r - b.center.r - {1[m], 0[m]}) = 1.5[m];",
    "an inverse cosine": "Block b(m = 1, base = turn(world, acos(0.3))); Revolute h(a = b.center); Bar c(m = 1, L = 1, a = h.b);"
                         "GeneralSpring s(V = 2[J]/cos(h.phi - 0.3), stretch = b.s);",
}


@pytest.mark.parametrize("what", SLANTED)
def test_what_is_printed_has_the_value_of_what_was_derived(what: str, tmp_path: Path, capsys, monkeypatch) -> None:
    derive_once(monkeypatch)
    (tmp_path / "scene.lag").write_text(f"model Scene\n  {SLANTED[what]}\nend Scene;\n", encoding="utf-8")
    with everything_laid_out() as told:
        for form in ALL_FORMS:
            code = main(["equations", str(tmp_path / "scene.lag"), "--form", form, "--force"])
            said = capsys.readouterr().err
            assert code == 0 or re.search(REFUSED.get(form, "nothing"), said), said
    assert [words for words in told if words] == [] and len(told) > 50


def test_a_parameter_called_t_is_not_the_time(tmp_path: Path, capsys) -> None:
    (tmp_path / "scene.lag").write_text(f"model Scene\n  {SLANTED['a parameter called t']}\nend Scene;\n", encoding="utf-8")
    assert main(["equations", str(tmp_path / "scene.lag")]) == 0
    said = capsys.readouterr().out
    assert "ρ t₁ s'' + k s = 0" in said and "t₁ is t." in said
    for target, line_ in (("sympy", "t_1 = sp.Symbol('t_1', real=True)  # t, m"), ("modelica", "rho*t_1*s_dd + k*s = 0;")):
        assert main(["export", str(tmp_path / "scene.lag"), "--to", target, "-o", "-"]) == 0
        assert line_ in capsys.readouterr().out


def test_sines_of_time_and_of_angles_stay_apart(tmp_path: Path, capsys) -> None:
    """No product becomes a sum of sines of phi + 300 t and phi - 300 t."""
    (tmp_path / "scene.lag").write_text(f"model Scene\n  {SLANTED['a vibrating pivot']}\nend Scene;\n", encoding="utf-8")
    for form in ("lagrange", "matrix"):
        assert main(["equations", str(tmp_path / "scene.lag"), "--form", form]) == 0
        assert "− 1800 m sin φ cos(300 t)" in capsys.readouterr().out


def test_a_parameter_that_changes_in_time_is_a_function_of_it(tmp_path: Path, capsys) -> None:
    text = "Block b(m = 1, base = world); Spring k(k = 10*(1 + 0.5*cos(4*time)), stretch = b.s);"
    (tmp_path / "scene.lag").write_text(f"model Scene\n  {text}\nend Scene;\n", encoding="utf-8")
    assert main(["equations", str(tmp_path / "scene.lag")]) == 0
    said = capsys.readouterr().out
    assert "k(t) = 5 cos(4 t) + 10" in said and "m s'' = − k(t) s" in said


def test_letters_that_the_scene_has_are_left_to_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A length L, a torque T, a voltage V and a damping D: the energies stand in script beside them."""
    scene = tmp_path / "letters.lag"
    scene.write_text("""model Letters
  parameter Length L = 1; parameter Mass T = 2; parameter Stiffness V = 10; parameter Damping D = 0.3;
  Prismatic x(a = world, along = {1, 0}); PointMass cart(m = T, center = x.b);
  Revolute phi(a = x.b); Bar bar(m = 1, L = L, a = phi.b);
  Spring s(k = V, stretch = x.s); Damper d(c = D, rate = der(x.s));
end Letters;""")
    for form, shown in (("lagrangian", "ℒ = 𝒯 − 𝒱 ="), ("energies", "𝒱_e = ½ V s²"), ("worked", "∂𝒯/∂s' =")):
        assert main(["equations", str(scene), "--form", form]) == 0
        assert shown in capsys.readouterr().out
    assert main(["equations", str(scene), "--form", "lagrange", "--format", "latex"]) == 0
    assert r"\frac{\partial \mathcal{T}}{\partial \dot{q}_{k}}" in capsys.readouterr().out


def test_notebooks_show_pages_typeset() -> None:
    """As Markdown, whatever they were printed as; scripts as code."""
    model = lag.load(EXAMPLES / "suspended_bar.lag")
    shown = model.equations("5.20", names={"tilt.phi": "θ"}, language="fr")
    assert shown.startswith("SuspendedBar") and "Équations de Lagrange, forme 5.20" in shown
    assert r"\ddot{\theta}" in shown._repr_markdown_() and r"\ddot" not in shown
    assert model.equations(format="sympy")._repr_markdown_().startswith('```python\n"""SuspendedBar')
