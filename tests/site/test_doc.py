"""`lag doc`: what the pages of components tell, and that they work from files in a browser."""

import re
import shutil
import subprocess
from collections.abc import Mapping
from html.parser import HTMLParser
from pathlib import Path

import pytest

from lagrangia.base.diagnostics import Source
from lagrangia.command.cli import main
from lagrangia.language.classes import build_class_table
from lagrangia.language.component_library import drawn_library
from lagrangia.language.syntax import parse
from lagrangia.site.formulas import formula
from lagrangia.site.pages import Package, library_title, site

OWN = """
model Soft "Spring that gives way, <b>softly</b>"
  extends Spring(k = 2);
  parameter Length s0 = 0.1 "where it gives";
  Length twice = 2*(s0 + 1[m]);
energy
  potential -k*s0^2/2*log(1 + (stretch/s0)^2);
  work k*(s0 - stretch) on b.r;
equation
  der(stretch) = if s0 > 0 then sqrt(2)*{1, 2} else dot(b.v, a.r)/norm(b.r);
end Soft;
"""


class Reader(HTMLParser):
    """Checks that all that is opened is closed, and keeps links."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.opened: list[str] = []
        self.links: list[str] = []
        self.feed(text)
        assert self.opened == []

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        if tag not in ("meta", "link", "input", "mspace"):
            self.opened.append(tag)
        self.links += [value for name, value in attributes if name in ("href", "src") and value]

    def handle_startendtag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        """Nothing stays open."""

    def handle_endtag(self, tag: str) -> None:
        assert self.opened.pop() == tag


@pytest.fixture(scope="module")
def pages() -> Mapping[str, str]:
    own = parse(Source("own.lag", OWN))
    springs = next(file for file in drawn_library() if file.source.name.endswith("springs.lag"))
    types = next(file for file in drawn_library() if file.source.name.endswith("types.lag"))
    table = build_class_table(drawn_library(), [])
    packages = [Package("own", (own,), build_class_table(drawn_library(), [own]), Path("own.lag")),
                *(Package(library_title(file.source), (file,), table, None) for file in (springs, types))]
    return dict(site(packages, [], lambda definition, scenes, runs: f"<svg><!--{len(scenes)} {runs}--></svg>"))


def test_pages_are_whole_and_their_links_lead_to_pages(pages: Mapping[str, str]) -> None:
    for name, text in pages.items():
        if name.endswith(".html"):
            assert set(Reader(text).links) <= set(pages), name


def test_what_a_page_tells(pages: Mapping[str, str]) -> None:
    page = pages["own.Soft.html"]
    assert "Spring that gives way, &lt;b&gt;softly&lt;/b&gt;" in page and "<b>" not in page
    cells = r"<tr><td><code>(\w+)</code></td><td>.*?>(\w+)</a></td><td>(.*?)</td><td>(?:<code>(.*?)</code>)?</td>"
    rows = re.findall(cells, page)
    assert ("twice", "Length", "m", "2*(s0 + 1[m])") in rows
    assert ("s0", "Length", "m", "0.1") in rows and ("k", "Stiffness", "N/m", "2") in rows
    assert page.count("<math") == 4, "its own energies and equation, and that of the spring"
    assert 'href="library.springs.Spring.html"' in page and "<figure><svg>" in page
    assert 'href="own.Soft.html"' in pages["library.springs.Spring.html"].partition("Used by")[2]
    assert "<figure>" not in pages["library.springs.Elastic.html"], "which is partial"


def test_formulas_stand_as_they_are_written() -> None:
    (own,) = parse(Source("own.lag", OWN)).classes
    energy, work, equation = (formula(clause) for section in own.sections for clause in section.clauses)
    assert "<mi>V</mi>" in energy and "<mi>log</mi>" in energy and "<mfrac>" in energy and "−" in energy
    assert "δ" in work and "<msqrt>" in equation and "<mtable>" in equation and "˙" in equation


def test_the_search_has_all_classes(pages: Mapping[str, str]) -> None:
    assert pages["search.js"].count('"page": ') == sum(name.endswith(".html") for name in pages) - 1


BROWSER = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")


@pytest.mark.skipif(BROWSER is None, reason="needs a browser")
def test_a_browser_shows_them_from_files_and_finds(pages: Mapping[str, str], tmp_path: Path) -> None:
    for name, text in pages.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    typed = '<script>field.value = "duff"; field.dispatchEvent(new Event("input"));</script></body>'
    (tmp_path / "index.html").write_text(pages["index.html"].replace("</body>", typed), encoding="utf-8")
    done = subprocess.run([str(BROWSER), "--headless", "--no-sandbox", "--disable-gpu", "--dump-dom",
                           (tmp_path / "index.html").as_uri()], capture_output=True, text=True, timeout=60, check=False)
    found = re.search(r'<div id="found">(.*?)</div>', done.stdout)
    assert found is not None
    assert re.findall(r'href="(.*?)">(\w+)', found[1]) == [("library.springs.DuffingSpring.html", "DuffingSpring")]


@pytest.mark.slow
def test_the_command_draws_most_of_the_library_and_packages(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    runs = "model Runs Block b(m = 1, base = world); end Runs;"
    (tmp_path / "own.lag").write_text(f"{OWN.partition('  work')[0]}end Soft;\n{runs}\n")
    own, target = tmp_path / "Own", tmp_path / "site"
    (own / "Sub").mkdir(parents=True)
    (own / "package.lag").write_text("package Own\n  record Wheel\n    parameter Length r = 0.3;\n  end Wheel;\nend Own;\n")
    (own / "Cart.lag").write_text("within Own;\nmodel Cart\n  extends Block(m = 2);\n"
                                  "  Sub.Damped d(c = 3, a = base, b = center);\n"
                                  "  Wheel w;\n  Rotational.Inertia J(J = w.r*1[kg.m]);\nend Cart;\n")
    (own / "Sub" / "package.lag").write_text("within Own;\npackage Sub\nend Sub;\n")
    (own / "Sub" / "Damped.lag").write_text("within Own.Sub;\nmodel Damped\n  extends Damper;\nend Damped;\n")
    assert main(["doc", str(tmp_path / "own.lag"), str(own), "-o", str(target)]) == 0
    pages = {file.name: file.read_text(encoding="utf-8") for file in target.glob("*.html")}
    assert all("<svg" in pages[f"library.{name}.html"] for name in ("springs.Spring", "joints.Revolute", "bodies.Bar",
                                                                   "constraints.Gear", "constraints.Stop", "loads.AppliedForce"))
    gear = pages["library.rotational.Rotational.IdealPlanetary.html"].partition("<svg")[2].partition("</svg>")[0]
    assert re.findall(r">(\w+)</tspan>", gear) == ["IdealPlanetary", "sun", "carrier", "ring"]
    assert "<svg" in pages["own.Soft.html"] and "<svg" in pages["own.Runs.html"]
    ports = pages["library.rotational.Rotational.Inertia.html"].partition("<h2>Ports")[2].partition("<h2>")[0]
    assert re.findall("<code>(\\w+)", ports) == ["flange_a", "flange_b"]
    for text in pages.values():
        assert set(Reader(text).links) <= {*pages, "site.css", "search.js"}
    cart = pages["Own.Own.Cart.html"]
    assert "<svg" in cart and 'href="Own.Own.Wheel.html">Wheel' in cart and 'href="Own.Own.Sub.Damped.html">Damped' in cart
    assert 'href="library.rotational.Rotational.Inertia.html">Inertia' in cart.partition("<h2>Source")[2]
    assert 'href="Own.Own.Cart.html"' in pages["library.rotational.Rotational.Inertia.html"].partition("Used by")[2]
    assert "radius" not in pages["Own.Own.html"] and 'href="Own.Own.Wheel.html"' in pages["Own.Own.html"]
    (own / "Astray.lag").write_text("model Astray\nend Astray;\n")
    assert main(["doc", str(own), "-o", str(target)]) == 2
    assert "its first line is `within Own;`" in capsys.readouterr().err
    assert main(["doc", "-o", str(tmp_path)]) == 2, "which holds something else"
    assert "holds something else" in capsys.readouterr().err


def test_names_in_quotes_lead_nowhere_else() -> None:
    """A class may be called anything: its page stays in the folder, and those of two names are two."""
    names = ("'../../up'", "'.. .. up'", "'a/b'", "'" + "x" * 300 + "'", "Plain")
    syntax = parse(Source("own.lag", "\n".join(f"model {name} Block b(m = 1, base = world); end {name};" for name in names)))
    package = Package("own", (syntax,), build_class_table(drawn_library(), [syntax]), Path("own.lag"))
    files = [package.page(definition) for definition in package.classes]
    assert len(set(files)) == len(names) and files[-1] == "own.Plain.html"
    assert all(re.fullmatch(r"own\.[\w.]{1,170}\.html", file) for file in files)


def test_sources_command_no_terminal() -> None:
    """A description with an escape came into the page as it was, which HTML may not hold."""
    syntax = parse(Source("own.lag", 'model M "red \x1b[31m"\n  Block b(m = 1, base = world) "\u202e";\nend M;\n'))
    package = Package("own", (syntax,), build_class_table(drawn_library(), [syntax]), Path("own.lag"))
    page = dict(site([package], [], lambda definition, scenes, runs: ""))["own.M.html"]
    assert r"red \x1b[31m" in page and r"\x202e" in page and "\x1b" not in page and "\u202e" not in page
