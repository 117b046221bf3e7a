"""Every warning there is: told by its code, in the list of `lag help warnings`, an error under --strict, and silenced by its code
in the text and on the command line."""

import re
from pathlib import Path

import pytest

from lagrangia.base.diagnostics import WARNINGS
from lagrangia.command.cli import main

DONE, WRONG = 0, 2
BLOCK, HANGING = "Block b(m = 1, base = world);", "PointMass P(m = 1, center = shift(h.b, {0, -1}));"
SPACE = "World world(gravity = {0, 0, -9.81});"
PUSHED = f"{BLOCK} input Force u; AppliedForce f(at = b.center, force = {{u, 0}});"
MANY = "".join(f"Block b{i}(m = 1, base = world); " for i in range(61))
CASES = {  # what a scene says, and the command that tells
    "L0224": (f"parameter Length L = 1; {BLOCK}", "check"),
    "L0237": (f"{BLOCK} equation when b.s > 1 then reinit(b.v, 0); elsewhen b.v > 3 then reinit(b.v, 1); end when;", "check"),
    "L0238": (f'{BLOCK} equation assert(1 > 2, "never", AssertionLevel.warning);', "check"),
    "L0239": (f"{BLOCK} equation when cos(2*pi*time/1[s]) <= -1 then reinit(b.v, 1); end when;", "check"),
    "L0305": ("Revolute h(a = world, w(start = 3[Hz])); Bar p(m = 1, L = 1, a = h.b);", "check"),
    "L0306": (f"{SPACE} PointMass p(m = 1); AppliedForce f(at = p.center, force = {{1, 2}});", "check"),
    "L0607": (f"{BLOCK} Spring s(k = 1, s_rel0 = 0.5, a = world, b = b.center);", "check"),
    "L0608": ("Revolute h(a = world, phi(start = 1)), g(a = b.b); Bar b(m = 1, L = 1, a = h.b), c(m = 1, L = 1, a = g.b); "
              "Motion d(of = h.phi, to = time*1[rad/s]);", "check"),
    "L0609": (f"{BLOCK} initial equation der(b.s)^2 = 4;", "check"),
    "L0610": (f'{BLOCK} equation assert(time < 0.05[s], "late", AssertionLevel.warning);', "simulate"),
    "L0708": (PUSHED, "simulate"),
    "L0709": (PUSHED, "simulate -u u.csv --stop 2"),
    "L0740": (f"Frame q = shift(world, {{0, 0.05*cos(200*time)}}); Revolute h(a = q); {HANGING}", "modes"),
    "L0741": (f'{BLOCK} equation assert(b.s < 1, "far");', "export --to python"),
    "L0742": (BLOCK, "check"),
    "L0743": (f"{BLOCK} GeneralSpring s(stretch = b.s, V = 50*max(0, -s.stretch)^2 + 5*max(0, s.stretch)^2);", "modes"),
    "L0744": (f"{BLOCK} GeneralSpring s(stretch = b.s, V = if s.stretch > 1 then 5 else 0);", "check"),
    "L0745": (f"{MANY} energy kinetic 1[kg]*b0.v^2/2;", "check"),
    "L0746": (f"{SPACE} Body b(m = 1, I = {{1, 1, 3}});", "check"),
    "L0747": ("parameter Mass m = 1; parameter Mass n = 2*m; Block b(m = n, base = world);", "simulate -p m=2 -p n=3"),
    "L0748": (f"{BLOCK} Spring s(k = 1, stretch = b.s);", "sweep -p s.k=1:2:0.3"),
    "L0749": (BLOCK, "check"),
    "L0801": (BLOCK, "lint"),  # of what stands before
    "L0802": ("parameter Mass pi = 1; Block b(m = pi, base = world);", "lint"),
    "L0803": (f"{BLOCK} Spring s(k = 1, stretch = b.s - 0.3[m]); output Length x = b.s*2 + 0.27[m];", "lint"),
    "L0804": ("Block Sledge(m = 1, base = world);", "lint"),
    "L0805": (f'parameter Real k(unit = "N/m") = 1; {BLOCK} Spring s(k = k, stretch = b.s);', "lint"),
    "L0806": (BLOCK, "lint"),
}


FAULTY = 1  # the exit code of lag lint


@pytest.mark.parametrize("code", WARNINGS)
def test_each_is_an_error_where_it_is_asked_for_and_can_be_allowed(
        code: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """A code without a case here fails: its warning goes by no other way than those of all others."""
    monkeypatch.chdir(tmp_path)
    Path("u.csv").write_text("time,u\n0,0\n1,1\n")
    if code == "L0742":
        (shared := tmp_path / "shared").mkdir()
        shared.chmod(0o777)
        monkeypatch.setenv("LAGRANGIA_CACHE", str(shared))
    if code == "L0749":
        monkeypatch.setenv("LAGRANGIA_CACH", str(tmp_path))
    text, command = CASES[code]
    name, *options = command.split()

    def run(allowed: str, *more: str) -> tuple[int, bool]:
        file = Path("M.lag")
        before = f"partial model N Frame a; annotation(Icon(){allowed}); end N; " if code == "L0801" else ""
        file.write_text(f"{before}model M {text} annotation(experiment(StopTime = 0.1){allowed}); end M;")
        if name == "lint" and code != "L0806":
            main(["format", str(file)])
        done = main([name, str(file), *options, *more])
        told = capsys.readouterr().err
        assert (f"warning[{code}]" in told) == bool(told), told
        return done, bool(told)

    assert run("") == (FAULTY if name == "lint" else DONE, True)
    assert run("", "--strict") == (WRONG, True)
    assert run("", "--strict", "--allow", code) == run(f', allow = "{code}"', "--strict") == (DONE, False)


def test_there_is_a_list_of_them(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["help", "warnings"]) == DONE
    told = capsys.readouterr().out
    assert re.findall(r"^(L\d{4})  \w", told, re.MULTILINE) == sorted(WARNINGS) == list(CASES)


def test_all_files_are_told_before_strict_ends(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    files = [tmp_path / f"{name}.lag" for name in "ab"]
    for file in files:
        file.write_text(f"model M {CASES['L0224'][0]} end M;")
    assert main(["check", "--strict", *map(str, files)]) == WRONG
    told = capsys.readouterr().err
    assert all(str(file) in told for file in files)


@pytest.mark.parametrize(("name", "value", "said"), [
    ("LAGRANGIA_CACH", "x", "did you mean 'LAGRANGIA_CACHE'?"),
    ("LAGRANGIA_PATH", "nowhere", "names 'nowhere', which is no folder"),
    ("LAGRANGIA_CC", "no_compiler_of_this_name -O2", "names the C compiler 'no_compiler_of_this_name', which is not there")])
def test_what_environments_say_in_vain_is_told(name: str, value: str, said: str, tmp_path: Path,
                                               capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(name, value)
    (tmp_path / "M.lag").write_text(f"model M {BLOCK} end M;")
    assert main(["check", str(tmp_path / "M.lag")]) == DONE
    told = capsys.readouterr().err
    assert told.count("L0749") == 1 and said in told


def test_pages_of_equations_tell_inertias_that_no_body_has(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """As other commands do: of what is declared, and of what is given."""
    (file := tmp_path / "m.lag").write_text(f"model M {SPACE} Body b(m = 1, I = {{1, 1, 1}}); end M;")
    assert main(["equations", str(file)]) == DONE and not capsys.readouterr().err
    assert main(["equations", str(file), "--numbers", "-p", "b.I[3]=3"]) == DONE
    assert "warning[L0746]: no rigid body has the inertia 'b.I'" in capsys.readouterr().err
    file.write_text(file.read_text().replace("1, 1, 1", "1, 1, 3"))
    assert main(["equations", str(file)]) == DONE and "warning[L0746]" in capsys.readouterr().err
