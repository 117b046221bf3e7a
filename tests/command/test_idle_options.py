"""Nothing written after a command is without effect and without a word: what is given twice, or belongs to something else."""

import re
import shlex
from pathlib import Path

import pytest

from lagrangia.base.diagnostics import WARNINGS
from lagrangia.command.cli import WRONG, main
from lagrangia.command.idle_options import RULES, flag

SCENE = """model M
  parameter Mass m = 1; parameter Integer n = 2; parameter Real k[2] = {2, 3}; input Force u(start = 0);
  Block b(m = m, base = world, s(start = 0.1)); Spring s(k = k[1], stretch = b.s), t(k = k[2], stretch = b.s);
  AppliedForce f(at = b.center, force = {u, 0}); output Length y = n*b.s;
end M;
"""
TWICE = """simulate -p m=1 -p m=2; simulate -p n=3 -p n=4; simulate -p k={4,5} -p k[1]=2; simulate -p k[1]=2 -p k={4,5}
simulate -u u=0 -u u=2; simulate -u u=0 -u u.csv; simulate --initial b.s=1 --initial b.s=2; simulate --stop 1 --stop 2
simulate -o a.csv --output b.csv; simulate --model M --model M; simulate --outputs y,y
simulate --plot p.svg --plot-quantities y,y
sweep -p m=1,2 -p m=3; sweep --outputs y,final(y); sweep -u u=0 -u u=1; explain -p m=1 -p m=2; equations -p m=1 -p m=2
equations --form worked --sections kinetic,kinetic; modes -p m=1 -p m=2; linearize --from u,u; linearize --to y,y
export --to fmu --info author=x --info author=y; export --to fmu --outputs y,y; draw --initial b.s=1 --initial b.s=2
animate --trace b.center,b.center; animate --curves y,y; simulate --plot p.svg --spectrum y,y
simulate --plot p.svg --beside m=1,m=2; simulate --plot p.svg --overlay u.csv --overlay u.csv"""
IDLE = """simulate --at 0,1 --interval 0.1; simulate --plot-quantities y; simulate --stats --quiet; simulate --dump flat --stop 3
simulate --dump flat -o x.csv; simulate --solver casadi:cvodes --engine tape; simulate --solver casadi:cvodes --max-step 0.1
simulate --solver linear --max-step 0.1; equations --about b.s=1; equations --level short; equations --sections kinetic
equations --first-letter f; equations --check b.s=0 --format latex; response --at 1,2 --range 1:10; response --at 1 --points 30
export --to python --force; simulate --spectrum y; simulate --section y; simulate --overlay u.csv; simulate --linear
simulate --beside m=2; equations --check b.s=0 --language de; equations --format sympy --language de
equations -o x.py --language de; equations -o x.py --form worked --level lecture
equations --format sympy --form worked --sections x; equations --check b.s=0 --form matrix; bench --rhs --stop 3
equations --check b.s=0 --sources force; sweep --restart -o -; modes --view 10,20; bench --rhs --tolerances 1e-3
simulate --dump flat --from equilibrium; simulate --dump flat --solver erk; simulate --dump flat --engine tape
simulate --dump flat --outputs y; simulate --dump motion --reactions; simulate --dump flat -p m=2"""
OTHERS = {"simulate --outputs ,": "names nothing", "simulate --allow L9999": "no warning 'L9999'",
          "sweep -p m=1,2 --seed 3": "random",
          "sweep -p m=1,2 --sampling lhs": "random", "sweep -p m=1,2 --together": "side by side"}


def commands(text: str) -> list[str]:
    return [command for line in text.splitlines() for command in line.split("; ")]


@pytest.fixture
def told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]):
    monkeypatch.chdir(tmp_path)
    Path("c.lag").write_text(SCENE)
    Path("u.csv").write_text("time,u\n0,0\n1,1\n")

    def run(command: str) -> str:
        name, *rest = shlex.split(command)
        try:
            code = main([name, "c.lag", *rest])
        except SystemExit as stop:
            code = int(stop.code or 0)
        assert code == WRONG, command
        return capfd.readouterr().err

    return run


@pytest.mark.parametrize("command", commands(TWICE))
def test_what_is_given_twice_is_refused(told, command: str) -> None:
    assert "twice" in told(command)


@pytest.mark.parametrize("command", commands(IDLE))
def test_what_belongs_to_something_else_is_refused(told, command: str) -> None:
    assert "has no effect here" in told(command)


@pytest.mark.parametrize("command", OTHERS)
def test_what_has_nothing_to_choose_from_is_refused(told, command: str) -> None:
    assert OTHERS[command] in told(command)


@pytest.mark.parametrize("options", ["-p L=2 --numbers", "--numbers -p k=3", "--format sympy -p k=3", "--form linear -p L=2"])
def test_values_of_parameters_are_taken_without_a_word(tmp_path: Path, options: str, capsys: pytest.CaptureFixture[str]) -> None:
    """A scene whose own value is none is not derived with it; a value that is the scene's own is no fault."""
    (tmp_path / "f.lag").write_text("""model F parameter Length L = -1; parameter TorsionStiffness k = 3;
      Revolute h(a = world, phi(start = 0.3)); Bar b(m = 1, L = L, a = h.b); TorsionSpring s(a = world, b = h.b, k = k);
      equation assert(L > 0, "no length"); end F;""")
    given = options if "L=" in options else f"{options} -p L=2"
    assert main(["equations", str(tmp_path / "f.lag"), *given.split()]) == 0
    assert not capsys.readouterr().err


@pytest.mark.parametrize("options", ["", "--format markdown", "--form matrix --sources force", "--form 5.16"])
def test_values_of_parameters_on_a_page_of_symbols_are_told(tmp_path: Path, options: str, capsys: pytest.CaptureFixture[str]
                                                            ) -> None:
    (tmp_path / "c.lag").write_text(SCENE)
    assert main(["equations", str(tmp_path / "c.lag"), "-p", "m=2", *options.split(), "--strict"]) == WRONG
    told = capsys.readouterr().err
    assert "-p m=2 has no effect: this page is in symbols" in told
    assert ("--sources force has no effect" in told) == ("force" in options)


def test_what_is_usual_may_be_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("c.lag").write_text(SCENE)
    for command in ("simulate c.lag --at 0,1 --solver linear --engine auto -u u=0", "equations c.lag --level full",
                    "sweep c.lag -u u=0 -p m=1,2 --outputs at(0,y),at(1,y) --sampling random"):
        assert main(command.split()) == 0


def test_every_rule_names_options_of_its_commands() -> None:
    folder = Path(__file__).parents[2] / "compiler" / "lagrangia" / "command"
    text = "".join(file.read_text(encoding="utf-8") for file in folder.glob("*_options.py") if file.stem != "idle_options")
    for rule in RULES:
        assert all(f'"{flag(name)}"' in text for name in rule.options if name != "input")


def test_the_codes_of_warnings_are_those_that_are_told() -> None:
    package = Path(__file__).parents[2] / "compiler" / "lagrangia"
    pattern = re.compile(r'warning\(\s*"(L\d{4})"|warning\[(L\d{4})\]|"warning", "(L\d{4})"')
    found = {next(filter(None, match.groups())) for path in package.rglob("*.py") for match in pattern.finditer(path.read_text())}
    assert found == set(WARNINGS)


def test_limits_of_variables_of_functions_are_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Also beside --dump, where --strict had no effect."""
    file = tmp_path / "f.lag"
    file.write_text("""function half input Real x(min = 0); output Real y(max = 0.1); algorithm y := x/2; end half;
model M Block b(m = 1, base = world); output Real y = half(b.s - 7); end M;""")
    for command in (["check"], ["simulate", "--dump", "flat"]):
        assert main([*command, str(file), "--strict"]) == WRONG
        told = capsys.readouterr().err
        assert "'min' of 'x' of half has no effect" in told and "'max' of 'y' of half" in told and told.count("L0224]:") == 2
