"""Texts, caches and files of others are data: nothing in them runs, and nothing of them is shown that nobody asked for."""

import os
import pickle
import re
import subprocess
import sys
import zipfile
from dataclasses import fields, is_dataclass
from pathlib import Path

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.base.diagnostics import Source
from lagrangia.base.folders import cache_folder, data_folder
from lagrangia.base.own_python import own_command, own_environment
from lagrangia.base.store import find_kept, keep, key_of, prune
from lagrangia.command.cli import main
from lagrangia.language.plain_tree import read_trees, write_trees
from lagrangia.language.syntax import parse
from lagrangia.native.build import Objects, build, find_compiler

needs_compiler = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
SWING = 'model Swing "%s"\n  Revolute h(a = world, phi(start = 1)); Bar b(m = 1, L = 1, a = h.b);\nend Swing;\n'
MARK = "open('MARK', 'w').close()"


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize("description", [
    rf'x \"\"\"; {MARK}; y = \"\"\" z', rf'ends in a quote \"\"\"\n{MARK}\n\"\"\"', r"from C:\\Users\\bench\\x\\N{no}",
    r"a \\\"\"\" b", 'it ends \\"',
])
@pytest.mark.parametrize("target", ["python", "sympy"])
def test_descriptions_stay_text_in_exports(description: str, target: str) -> None:
    Path("scene.lag").write_text(SWING % description, encoding="utf-8")
    assert main(["export", "scene.lag", "--to", target, "-o", "made.py"]) == 0
    compile(Path("made.py").read_text(encoding="utf-8"), "made.py", "exec")
    if target == "python":
        assert subprocess.run([sys.executable, "made.py"], capture_output=True, timeout=60, check=False).returncode == 0
    else:
        exec(Path("made.py").read_text(encoding="utf-8").split("import sympy")[0], {})  # the docstring alone: it is quick
    assert not Path("MARK").exists()


def test_names_stay_text_in_markdown(capsys: pytest.CaptureFixture[str]) -> None:
    Path("scene.lag").write_text("model '<script>alert(1)</script>'\n  Block b(m = 1, base = world);\n"
                                 "  input Force '<script>u|'; parameter Stiffness '<img src=x>' = 3;\n"
                                 "  Spring s(k = '<img src=x>', stretch = b.s);\n"
                                 "  AppliedForce f(at = b.center, force = {'<script>u|', 0});\n"
                                 "end '<script>alert(1)</script>';\n", encoding="utf-8")
    assert main(["equations", "scene.lag", "--format", "markdown"]) == 0
    said = capsys.readouterr().out
    assert r"\lt script>u" in said and r"\lt img" in said and not re.search(r"(?<!\\)<[A-Za-z/!?]", said)


def test_names_of_files_and_columns_command_no_terminal(tmp_path: Path, monkeypatch, capsys: pytest.CaptureFixture[str]) -> None:
    """As of an archive that was unpacked, or of somebody's table."""
    monkeypatch.chdir(tmp_path)
    text = "model M input Force u; Block b(m = 1, base = world); AppliedForce f(at = b.center, force = {u, 0}); %s end M;"
    Path("\033[31mx.lag").write_text(text % "")
    Path("\033[2Jy.lag").write_text(text % "Bar c;")
    Path("t.csv").write_text("time,\033[2Jx\n0,1\n")
    main(["check", "\033[31mx.lag"])
    main(["check", "\033[2Jy.lag"])
    main(["simulate", "\033[31mx.lag", "-u", "t.csv"])
    main(["simulate", "\033[31mx.lag"])
    main(["explain", "\033[31mx.lag"])
    main(["format", "\033[2Jy.lag"])
    main(["draw", "\033[31mx.lag"])
    Path("\033[2Jr.urdf").write_text('<robot name="r"><link name="a"/><link name="\x9b2Jb"/><joint name="\x9b2Jj" type="odd">'
                                    '<parent link="a"/><child link="\x9b2Jb"/></joint></robot>', encoding="utf-8")
    main(["import", "\033[2Jr.urdf"])
    said = "".join(capsys.readouterr())
    assert "joint '\\x9b2Jj'" in said and "\x9b" not in said
    assert "\\x1b[31mx.lag" in said and "\\x1b[2Jy.lag" in said and "\\x1b[2Jx" in said and "\033" not in said


def test_names_of_a_foreign_fmu_command_no_terminal(capsys: pytest.CaptureFixture[str]) -> None:
    Path("scene.lag").write_text(SWING % "", encoding="utf-8")
    assert main(["export", "scene.lag", "--to", "fmu", "-o", "own.fmu", "--engine", "tape", "--no-sources"]) == 0
    with zipfile.ZipFile("own.fmu") as own, zipfile.ZipFile("foreign.fmu", "w") as foreign:
        for name in own.namelist():
            content = own.read(name)
            if name == "modelDescription.xml":
                for attribute in (b'modelName="', b'generationTool="'):
                    content = content.replace(attribute, attribute + b"\xc2\x9b2J")
            foreign.writestr(name, content)
    main(["simulate", "foreign.fmu", "--stop", "0.1", "--stats"])
    said = "".join(capsys.readouterr())
    assert "\\x9b2JSwing" in said and "\x9b" not in said


@pytest.mark.parametrize("name", ["a/../../../out", "a/../out", "/tmp/out", "..", "a b", "$(touch MARK)"])
@pytest.mark.parametrize("target", ["python", "modelica", "casadi"])
def test_a_name_of_a_model_leads_nowhere(name: str, target: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Files that nobody named are written into this folder, whatever stands between the quotes."""
    (here := tmp_path / "x" / "y" / "z").mkdir(parents=True)
    monkeypatch.chdir(here)
    Path("scene.lag").write_text(f"model '{name}'\n  Block b(m = 1, base = world);\nend '{name}';\n", encoding="utf-8")
    assert main(["export", "scene.lag", "--to", target]) == 0
    made = [path for path in tmp_path.rglob("*") if path.is_file() and path.name != "scene.lag"]
    assert len(made) == 1 and made[0].parent == here and made[0].stem.isidentifier()


@pytest.mark.parametrize("name", ["secret.txt", "secret", "secret.conf", "link.lag"])
def test_no_line_of_a_foreign_file_is_shown(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    Path("secret.txt").write_text("account: anna, pass phrase: mountain-lake-17\n", encoding="utf-8")
    if name == "link.lag":
        Path(name).symlink_to("secret.txt")
    elif name != "secret.txt":
        Path(name).write_text(Path("secret.txt").read_text())
    Path("scene.lag").write_text(f'import "{name}";\nmodel A\n  PointMass p(m = 1);\nend A;\n', encoding="utf-8")
    assert main(["check", "scene.lag"]) == 2
    told = capsys.readouterr().err
    assert "error[L0002]" in told and "is no Lagrangia file" in told
    assert "mountain" not in told


@pytest.mark.parametrize("name", ["link.urdf", "link.xml", "link.mo", "page.xml", "page.urdf"])
def test_no_line_of_a_file_that_is_not_imported_is_shown(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    Path("secret.txt").write_text("account: anna, pass phrase: mountain-lake-17\n", encoding="utf-8")
    Path("page").write_text('<secrets of="mountain-lake-17"/>', encoding="utf-8")
    Path(name).symlink_to("page" if name.startswith("page") else "secret.txt")
    assert main(["import", name]) == 2
    told = capsys.readouterr().err
    assert f"'{name}' is" in told and "mountain" not in told


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="POSIX owners and modes")
@needs_compiler
def test_a_cache_that_others_may_write_is_not_used(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    shared = tmp_path / "shared"
    shared.mkdir()
    shared.chmod(0o777)
    Path("scene.lag").write_text(SWING % "", encoding="utf-8")
    environment = {**os.environ, "LAGRANGIA_CACHE": str(shared), "XDG_CACHE_HOME": str(tmp_path / "own")}
    done = subprocess.run([sys.executable, "-m", "lagrangia", "check", "scene.lag"], capture_output=True, text=True, timeout=60,
                          env=environment, check=False)
    assert done.returncode == 0
    assert "warning[L0742]" in done.stderr and str(shared) in done.stderr
    assert list(shared.iterdir()) == []
    assert any((tmp_path / "own").rglob("*"))


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="POSIX owners and modes")
def test_files_that_others_may_write_are_not_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LAGRANGIA_CACHE", str(tmp_path / "cache"))
    key = key_of("something")
    keep("syntax", key, b"content")
    assert find_kept("syntax", key) == b"content"
    (cache_folder() / "syntax" / key).chmod(0o666)
    assert find_kept("syntax", key) is None


def test_the_cache_is_bounded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LAGRANGIA_CACHE", str(tmp_path / "cache"))
    for k in range(10):
        keep("scenes", f"scene{k}", bytes(1000))
        os.utime(cache_folder() / "scenes" / f"scene{k}", (1e9 + k, 1e9 + k))
    stray = cache_folder() / ".scene-killed"
    stray.mkdir()
    (stray / "scene.c").write_text("half")
    os.utime(stray / "scene.c", (1e9, 1e9))
    prune(most=3500)
    assert sorted(path.name for path in (cache_folder() / "scenes").iterdir()) == ["scene7", "scene8", "scene9"]
    assert not stray.exists()
    keep("scenes", "scene10", bytes(9000))
    prune(most=3500)  # once a day
    assert (cache_folder() / "scenes" / "scene10").exists()


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes")
def test_pipes_and_links_in_the_cache_are_no_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A pipe was read for ever; a link to nowhere ended each pruning before it began."""
    monkeypatch.setenv("LAGRANGIA_CACHE", str(tmp_path / "cache"))
    keep("scenes", "old", bytes(3000))
    os.utime(cache_folder() / "scenes" / "old", (1e9, 1e9))
    os.mkfifo(cache_folder() / "scenes" / "pipe")
    (cache_folder() / "scene-link").symlink_to(tmp_path / "nowhere")
    assert find_kept("scenes", "pipe") is None
    keep("scenes", "pipe", b"made again")
    assert find_kept("scenes", "pipe") == b"made again"
    prune(most=1000)
    assert not (cache_folder() / "scenes" / "old").exists()


@needs_compiler
def test_a_link_in_the_place_of_a_library_is_replaced(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where others may write to what it leads to; it ended in 'Not a directory'."""
    monkeypatch.setenv("LAGRANGIA_CACHE", str(tmp_path / "cache"))
    folder, elsewhere = build("one", "int one(void) { return 1; }", level="-O0").parent, tmp_path / "elsewhere"
    folder.rename(elsewhere)
    elsewhere.chmod(0o777)
    folder.symlink_to(elsewhere)
    assert build("one", "int one(void) { return 1; }", level="-O0").parent == folder
    assert not folder.is_symlink() and elsewhere.exists()


@needs_compiler
def test_what_is_kept_is_not_written_through_links(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The digest of an object was, into whatever file the link led to; a link to nowhere in a folder's place ended runs."""
    monkeypatch.setenv("LAGRANGIA_CACHE", str(tmp_path / "cache"))
    source, mine, compiler = tmp_path / "one.c", tmp_path / "mine", find_compiler()
    assert compiler is not None
    source.write_text("int one(void) { return 1; }\n")
    mine.write_text("mine")
    cache_folder().joinpath("objects").symlink_to(tmp_path / "nowhere")
    for _ in range(2):
        objects = Objects([source], [], "-O0", compiler)
        objects.finish()
        (made,) = objects.paths
        assert not made.parent.is_symlink() and not made.is_symlink() and len(made.with_suffix(".sha256").read_text()) == 64
        made.unlink()
        made.mkdir()
        made.with_suffix(".sha256").unlink()
        made.with_suffix(".sha256").symlink_to(mine)
    assert mine.read_text() == "mine"
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder" / "mine").write_text("mine")
    (cache_folder() / "scenes").symlink_to(tmp_path / "folder")
    prune(most=0)
    assert (tmp_path / "folder" / "mine").exists()


def test_a_cache_may_be_relative(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LAGRANGIA_CACHE", "near")
    assert cache_folder() == tmp_path / "near"


def test_syntax_trees_are_kept_as_plain_data() -> None:
    files = sorted((data_folder("models") / "library").glob("*.lag"))
    parsed = tuple(parse(Source(file.name, file.read_text(encoding="utf-8"))) for file in files)
    found = read_trees(write_trees(parsed))
    assert [_plain(file) for file in found] == [_plain(file) for file in parsed]


def _plain(node: object) -> object:
    """A tree in a form that compares by what is in it: sources are equal by their names."""
    if isinstance(node, Source):
        return node.name
    if isinstance(node, tuple):
        return tuple(map(_plain, node))
    return (type(node), *(_plain(getattr(node, field.name)) for field in fields(node))) if is_dataclass(node) else node


@needs_compiler
def test_results_and_errors_are_pickled() -> None:
    model = lag.load(data_folder("models") / "examples" / "quarter_car.lag")
    for found in (model.modes(), model.equilibrium(), model.linearize(), model.response(points=3),
                  model.simulate_many(parameters={"m1": [1, 2]}, outputs=["max(car.s)"])):
        again = pickle.loads(pickle.dumps(found))
        assert type(again) is type(found) and repr(again) == repr(pickle.loads(pickle.dumps(again)))
    assert pickle.loads(pickle.dumps(model.modes())).frequencies.tolist() == model.modes().frequencies.tolist()
    with pytest.raises(lag.Error) as raised:
        model.simulate(parameters={"zz": 1})
    again = pickle.loads(pickle.dumps(raised.value))
    assert isinstance(again, lag.LagError) and str(again) == str(raised.value)


def test_models_and_trajectories_are_pickled(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    Path("scene.lag").write_text(SWING % "", encoding="utf-8")
    model = lag.load("scene.lag")
    fresh = pickle.loads(pickle.dumps(model))
    run, again = model.simulate(), fresh.simulate()
    sent = pickle.dumps(model)
    (tmp_path / "elsewhere").mkdir()
    with monkeypatch.context() as other:  # processes may work in other folders
        other.chdir(tmp_path / "elsewhere")
        used = pickle.loads(sent)
        assert model.freedom and model.readers is not None and model.equations()  # nor is anything missed after a chdir
    assert used.parameter_names == model.parameter_names
    np.testing.assert_array_equal(run.rows, again.rows)
    kept = pickle.loads(pickle.dumps(run))
    np.testing.assert_array_equal(kept["h.phi"], run["h.phi"])
    np.testing.assert_array_equal(kept["b.b.x"], run["b.b.x"])
    np.testing.assert_array_equal(kept.energy.total, run.energy.total)
    with pytest.raises(TypeError, match="send the model, and call prepare there"):
        pickle.dumps(model.prepare())


def test_files_that_changed_since_they_were_loaded_are_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What was made of a model before, and what is made later, were of two texts; so were a model and its pickle. Tables and
    imported files are found from other folders, and none is written over."""
    monkeypatch.chdir(tmp_path)
    for name, text in {"road.csv": "x,y\n0,0\n1,1\n", "sub.lag": "model S Block b(m = 1, base = world); end S;"}.items():
        Path(name).write_text(text)
    text = 'import "sub.lag"; model R extends S; output Real y = table(b.s, "road.csv", column = 2); end R;'
    Path("r.lag").write_text(text)
    model = lag.load("r.lag")
    Path("other").mkdir()
    monkeypatch.chdir("other")
    assert "is b.s" in model.equations() and model.export_fmu("r.fmu", sources=False)
    with pytest.raises(lag.LagError, match="a result does not take its place"):
        lag.load("../r.lag").simulate_many(initial={"b.s": [0, 1]}, path="../road.csv")
    sent = pickle.dumps(model)
    Path("../r.lag").write_text(text.replace("2)", "1)"))
    for late in (lambda: pickle.loads(sent), lambda: model.reporting(("2*b.s",)), model.draw, model.equations):
        with pytest.raises(lag.LagError, match="has changed since it was loaded"):
            late()


def test_brackets_of_names_are_no_index_of_inputs(tmp_path: Path) -> None:
    """They were, in quotes and of arrays of components: equations and exports (Modelica, SymPy, FMU) ended with a bug."""
    file = tmp_path / "pushed.lag"
    file.write_text("model Pushed\n  Revolute h(a = world, phi(start = 1)); Bar b(m = 1, L = 1, a = h.b);\n  World world;\n"
                    "  input Force 'u [1]x'(start = 0); AppliedForce F(at = b.b, force = {'u [1]x', 0});\nend Pushed;\n")
    page = tmp_path / "page.txt"
    assert main(["equations", str(file), "-o", str(page)]) == 0 and "[1]x" in page.read_text(encoding="utf-8")
    file.write_text("model Two\n  World world;\n  model P\n    outer World world; Block b(m = 1, base = world); input Force u;\n"
                    "    AppliedForce F(at = b.center, force = {u, 0});\n  end P;\n  P c[2];\nend Two;\n")
    assert main(["equations", str(file), "--form", "lagrange", "-o", str(page)]) == 0


def test_quoted_names_are_whole_on_the_command_line(capsys: pytest.CaptureFixture[str]) -> None:
    """What is in them is no sign of the command line: = parted them, and a prime at their end was a rate."""
    Path("scene.lag").write_text(r"""model M
  parameter Integer 'n[x]' = 3; parameter Stiffness 'k=\'1,' = 3; parameter Boolean 'is:b=' = true;
  Block 'b=c'[2](each m = 'n[x]', each base = world); Spring s(k = 'k=\'1,', stretch = 'b=c'[1].s) if 'is:b=';
  input Force 'u=,(x'; AppliedForce f(at = 'b=c'[1].center, force = {'u=,(x', 0});
  output Length 'o,<3>=' = 'b=c'[1].s;
end M;""", encoding="utf-8")
    Path("u.csv").write_text("time,f\n0,0\n1,0\n")
    given = ["-p", r"'k=\'1,'=2", "--initial", "'b=c'[1].s=1", "-u", "'u=,(x'=u.csv", "--stop", "1"]
    assert main(["simulate", "scene.lag", *given, "-p", "'n[x]'=2", "-p", "'is:b='=true", "--outputs", "'o,<3>='", "-o", "r.csv",
                 "--plot-quantities", "'b=c'[1].s:'b=c'[1].s','o,<3>='", "--beside", r"'k=\'1,'=8", "--plot", "p.svg"]) == 0
    assert float(Path("r.csv").read_text().splitlines()[-1].rpartition(",")[2]) == pytest.approx(np.cos(1), abs=1e-7)
    assert main(["sweep", "scene.lag", "-p", r"'k=\'1,'=3,12", *given[2:], "--outputs", "final('o,<3>=')", "-o", "s.csv"]) == 0
    ends = [float(line.split(",")[-2]) for line in Path("s.csv").read_text().splitlines()[1:]]
    assert ends == pytest.approx([np.cos(1), np.cos(2)], abs=1e-7)
    assert main(["sweep", "scene.lag", "-p", "'n[x]'=1,2", *given, "--outputs", "final('o,<3>=')"]) == 2
    assert "which is compiled in" in capsys.readouterr().err


def test_pictures_are_drawn_without_latex() -> None:
    """A matplotlibrc in the folder had names read as commands of LaTeX, and where there is none it was 'bug:'."""
    import matplotlib

    Path("scene.lag").write_text(SWING % "", encoding="utf-8")
    Path("dollars.lag").write_text(SWING % r"of $\\frac{1$ and $", encoding="utf-8")
    assert main(["simulate", "dollars.lag", "--stop", "0.1", "--plot", "d.svg"]) == 0
    with matplotlib.rc_context({"text.usetex": True}):
        assert main(["simulate", "scene.lag", "--stop", "0.1", "--plot", "p.svg"]) == 0
        assert main(["modes", "scene.lag", "--plot", "m.svg"]) == 0
    Path("matplotlibrc").write_text("path.effects: 3\nfont.family: NoSuch\naxes.grid: True\nfont.size: 1e9\n")
    ask = ("import matplotlib, sys; from lagrangia.command.cli import main; matplotlib.rcParams['lines.linewidth'] = 3\n"
           "from lagrangia.view.curves import own_style\nwith own_style(): print(matplotlib.rcParams['lines.linewidth'])\n"
           "sys.exit(main(['draw', 'scene.lag', '-o', 'd.png']) or main('simulate scene.lag --stop 0.1 --plot r.svg'.split()))")
    done = subprocess.run([sys.executable, "-P", "-c", ask], env=own_environment(), capture_output=True, text=True, timeout=60,
                          check=False)
    assert done.returncode == 0 and done.stdout.startswith("3.0") and "NoSuch" not in done.stderr


def test_files_of_the_working_folder_are_not_run() -> None:
    """As what looks at saved texts did, with the folder that the editor had open in its path."""
    Path("scene.lag").write_text(SWING % "", encoding="utf-8")
    Path("json.py").write_text(MARK)
    Path("lagrangia").mkdir()
    Path("lagrangia/__init__.py").write_text(MARK)
    done = subprocess.run([*own_command("lagrangia.editor.whole"), "scene.lag"], env=own_environment(), capture_output=True,
                          timeout=60, check=False)
    assert done.stdout.strip() == b"[]" and not Path("MARK").exists()


def test_texts_and_names_with_signs_of_any_kind_are_themselves() -> None:
    """A backslash before n was a new line, and types whose names turn the reading direction were not found."""
    Path("scene.lag").write_text('package \'P\u202e\' type \'E\u202e\' = enumeration(x, y); end \'P\u202e\';\n'
                                 'model M "C:\\\\new\\\\table, \\"a\\"\\n\\tb"\n  import \'P\u202e\'.\'E\u202e\';\n'
                                 "  parameter 'E\u202e' e = 'E\u202e'.x;\n"
                                 "  Block b(m = if e == 'E\u202e'.x then 1 else 2, base = world);\nend M;\n", encoding="utf-8")
    assert lag.load("scene.lag").scene.description == 'C:\\new\\table, "a"\n\tb'
