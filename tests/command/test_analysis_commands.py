"""`lag equilibrium`, `linearize`, `modes`, `response`: text, files, pictures, and what is wrong."""

import csv
import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.command.cli import main

EXAMPLES = Path(__file__).resolve().parents[2] / "models" / "examples"
BAR = str(EXAMPLES / "suspended_bar.lag")
Lag = Callable[..., tuple[int, str, str]]


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Lag:
    monkeypatch.chdir(tmp_path)

    def call(*arguments: str) -> tuple[int, str, str]:
        try:
            code = main(arguments)
        except SystemExit as stop:
            code = int(stop.code or 0)
        said = capsys.readouterr()
        return code, said.out, said.err

    return call


def test_equilibrium_as_text_and_json(run: Lag) -> None:
    code, out, _ = run("equilibrium", str(EXAMPLES / "double_pendulum.lag"), "-o", "rest.json")
    assert code == 0
    assert "DoublePendulum: 4 equilibria" in out and "1: stable" in out and "reached from the start" in out
    assert "shoulder" in out and "-90 deg" in out and "F_y [N]" in out
    found = json.loads(Path("rest.json").read_text())
    assert [item["stability"] for item in found].count("stable") == 1
    weight = 9.81 * sum(lag.load(EXAMPLES / "double_pendulum.lag").parameter_values()[k] for k in masses())
    assert found[0]["reactions"]["shoulder.reaction[2]"] == pytest.approx(weight)


def masses() -> list[int]:
    names = lag.load(EXAMPLES / "double_pendulum.lag").parameter_names
    return [k for k, name in enumerate(names) if name in ("upper.m", "lower.m")]


def test_matrices_in_files(run: Lag) -> None:
    wanted = lag.load(BAR).linearize()
    code, out, _ = run("linearize", BAR, "-o", "bar.json")
    assert code == 0 and "P.force[2]" in out and "eigenvalues of A" in out
    plain = json.loads(Path("bar.json").read_text())
    np.testing.assert_array_equal(plain["A"], wanted.A)
    assert plain["states"] == ["guide.s", "tilt.phi", "der(guide.s)", "der(tilt.phi)"]
    assert run("linearize", BAR, "-o", "bar.npz")[0] == 0
    np.testing.assert_array_equal(np.load("bar.npz")["C_output"], wanted.output)
    scipy_io = pytest.importorskip("scipy.io")
    assert run("linearize", BAR, "-o", "bar.mat")[0] == 0
    np.testing.assert_array_equal(scipy_io.loadmat("bar.mat")["K"], wanted.K)


def test_a_control_object_has_the_names() -> None:
    control = pytest.importorskip("control")
    linear = lag.load(BAR).linearize()
    system = linear.to_control()
    assert system.state_labels == [name.replace(".", "_") for name in linear.states]
    assert system.input_labels == ["P_force[2]"]
    response = lag.load(BAR).response(frequencies=[1.0, 3.0])
    for k, f in enumerate(response.frequencies):
        np.testing.assert_allclose(control.evalfr(system, 2j * np.pi * f)[:, 0], response.values[k, :, 0], rtol=1e-9)


def test_modes_with_a_picture(run: Lag) -> None:
    for name, size in (("suspended_bar", 10_000), ("disc_and_block", 8_000), ("vibration_absorber", 8_000)):
        code, out, _ = run("modes", str(EXAMPLES / f"{name}.lag"), "--plot", "modes.png", "-o", "modes.json")
        assert code == 0 and "omega [rad/s]" in out
        assert Path("modes.png").stat().st_size > size
    plain = json.loads(Path("modes.json").read_text())
    assert len(plain["modes"]) == 2 and plain["modes"][0]["kind"] == "oscillation"
    code, out, _ = run("modes", str(EXAMPLES / "torsion_rotor.lag"), "--mass-normalised")
    assert code == 0 and "rigid-body motion" in out and "mass-normalised" in out


def test_frequencies_are_told_from_the_lowest_to_the_highest_one(run: Lag) -> None:
    """However they are given; one that stands twice is one."""
    code, out, _ = run("response", BAR, "--at", "3,1,3")
    assert code == 0 and "2 frequencies from 1 to 3 Hz" in out



def test_a_response_as_table_and_bode_plot(run: Lag) -> None:
    code, out, _ = run("response", BAR, "--to", "tilt.phi,bar.a.y", "-o", "bar.csv", "--plot", "bode.svg", "--points", "50")
    assert code == 0 and "tilt.phi / P.force[2] [rad/N]" in out and "peak" in out
    assert Path("bode.svg").stat().st_size > 5_000
    with Path("bar.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert len(rows) >= 50
    first = rows[0]
    value = complex(float(first["real(tilt.phi/P.force[2])"]), float(first["imag(tilt.phi/P.force[2])"]))
    assert abs(value) == pytest.approx(float(first["magnitude(tilt.phi/P.force[2])"]))
    modes = lag.load(BAR).modes()
    frequencies = [float(row["frequency"]) for row in rows]
    assert frequencies == sorted(frequencies)
    assert frequencies[0] < modes.frequencies[0] / 5 and frequencies[-1] > modes.frequencies[-1] * 5


def test_frequencies_are_no_times(run: Lag, tmp_path: Path) -> None:
    """An event after the end of the experiment is told whatever the frequencies, and not where --time is behind it."""
    scene = tmp_path / "event.lag"
    scene.write_text("""model Event Block b(m = 1, base = world); Spring s(k = 10, stretch = b.s); input Force u = 0;
        AppliedForce f(at = b.center, force = {u, 0}); equation when time > 15 then reinit(b.v, 1); end when;
        annotation(experiment(StopTime = 10)); end Event;""")
    for given, is_told in (("--at=1", True), ("--at=20,30", True), ("--time=20", False)):
        code, _, said = run("response", str(scene), given)
        assert code == 0 and ("this event never comes" in said) == is_told


def test_numbers_of_the_command_line(run: Lag) -> None:
    values = ("-p", "n=2", "-p", "link[1].L=1[m]", "--initial", "hinge[1].phi=-80[deg]")
    code, out, _ = run("modes", str(EXAMPLES / "chain.lag"), *values)
    assert code == 0 and out.count("hinge[2].phi") == 2


WRONG = {
    "modes nothing.lag": "L0001",
    f"modes {BAR} --plot x.txt": "L0004",
    f"modes {BAR} -o x.csv": "L0004",
    f"modes {BAR} --about somewhere": "L0702",
    f"linearize {BAR} --from nothing": "L0701",
    f"linearize {BAR} --to nothing": "L0701",
    f"linearize {BAR} --from k1": "L0717",
    f"linearize {BAR} --from guide.s": "L0717",
    f"linearize {BAR} --from der(guide.s)": "L0717",
    f"linearize {BAR} --from world.x": "L0717",
    f"linearize {BAR} -p k1=stiff": "L0706",
    f"equilibrium {BAR} --starts 0": "L0702",
    f"equilibrium {BAR} --time nan": "L0702",
    f"equilibrium {BAR} --initial nothing=1": "L0701",
    f"response {BAR} --range 3": "L0706",
    f"response {BAR} --range 3:1": "L0702",
    f"response {BAR} --range=-1:1": "L0702",
    f"response {BAR} --at 1,x": "L0706",
    f"response {BAR} --points 1": "L0702",
    f"response {BAR} --at 1e308": "L0702",
    f"response {BAR} --to ,": "L0706",
    f"linearize {BAR} --from P.force[": "L0711",
    f"linearize {BAR} -o nowhere/x.mat": "L0004",
    f"linearize {BAR} -o nowhere/x.json": "L0004",
    f"equilibrium {BAR} -o nowhere/x.json": "L0004",
    f"modes {BAR} --plot nowhere/x.png": "L0004",
    f"modes {BAR} -p m=nan": "L0706",
    f"equations {BAR} -o nowhere/x.txt": "L0004",
    f"equations {BAR} -o .": "L0004",
    f"export {BAR} --to casadi -o nowhere/x.casadi": "L0004",
    f"export {BAR} --to modelica -o nowhere/x.mo": "L0004",
    f"response {EXAMPLES / 'pendulum.lag'}": "L0718",
}


@pytest.mark.parametrize("command", list(WRONG))
def test_what_is_wrong(command: str, run: Lag) -> None:
    code, _, err = run(*command.split())
    assert code == 2, err
    assert f"error[{WRONG[command]}]" in err and "Traceback" not in err


def test_where_nothing_rests(run: Lag, tmp_path: Path) -> None:
    (tmp_path / "falling.lag").write_text("model Falling PointMass p(m = 1); end Falling;")
    for command in ("equilibrium", "modes", "linearize"):
        code, _, err = run(command, "falling.lag")
        assert code == 1 and "no equilibrium was found" in err
    (tmp_path / "still.lag").write_text("model Still Weld w(a = world); Bar b(m = 1, L = 1, a = w.b); end Still;")
    code, _, err = run("modes", "still.lag")
    assert code == 2 and "L0505" in err


@pytest.mark.parametrize("command", ["equilibrium", "modes", "linearize"])
def test_small_motion_out_of_the_range_of_numbers(command: str, run: Lag, tmp_path: Path) -> None:
    """k/m = 1e312 is none of them; 1e305 is, and its root is told."""
    (tmp_path / "tiny.lag").write_text("model Tiny Block b(m = 1, base = world); Spring s(k = 100, stretch = b.s); end Tiny;")
    code, _, err = run(command, "tiny.lag", "-p", "b.m=1e-310")
    assert code == 1 and err.startswith("error: small motion is out of the range of numbers here") and "Warning" not in err
    code, out, _ = run("modes", "tiny.lag", "-p", "b.m=1e-200", "-p", "s.k=1e105")
    assert code == 0 and "3.162278e+152" in out


def test_files_hold_json_also_of_singular_positions(run: Lag) -> None:
    """No NaN, which JSON does not know."""
    code, out, _ = run("equilibrium", str(EXAMPLES / "pantograph.lag"), "-o", "rest.json")
    assert code == 0 and "written to rest.json" in out and "ways of moving meet here" in out

    def refuse(name: str) -> None:
        raise AssertionError(name)

    found = json.loads(Path("rest.json").read_text(), parse_constant=refuse)
    assert [len(item["ways"]) for item in found].count(2) == 4  # all that are folded flat


def test_reactions_name_the_port_that_they_act_on(run: Lag, tmp_path: Path) -> None:
    """A block and a slider's port b are held up. No minus before a zero."""
    (tmp_path / "held.lag").write_text("""model Held Block c(m = 2, base = world); Spring s(k = 1, stretch = c.s);
        Prismatic p(a = world); PointMass m(m = 5, center = p.b); Spring u(k = 1, stretch = p.s); end Held;""")
    code, out, _ = run("equilibrium", "held.lag")
    rows = {line.split()[0]: line.split()[1:] for line in out.splitlines() if len(line.split()) == 4 and "=" not in line}
    assert code == 0
    assert (rows["c.center"], rows["p.b"]) == (["0", "19.62", "0"], ["0", "49.05", "0"])


def test_peaks_without_damping_have_no_height(run: Lag) -> None:
    code, out, _ = run("response", str(EXAMPLES / "disc_and_block.lag"), "--to", "block.s")
    assert code == 0 and out.count("no bound: resonance without damping") == 2
    assert "no bound" not in run("response", str(EXAMPLES / "disc_and_block_damped.lag"))[1]


def test_what_cannot_move_is_fixed(run: Lag, tmp_path: Path) -> None:
    (tmp_path / "truss.lag").write_text("""model Truss "two bars and a load"
  Revolute a(a = world), b(a = shift(world, {1, 0}), phi(start = 120[deg])), c(a = p.b, b = q.b);
  Bar p(m = 1, L = 1, a = turn(a.b, 60[deg])), q(m = 1, L = 1, a = b.b);
end Truss;""")
    code, out, _ = run("equilibrium", "truss.lag")
    assert code == 0
    assert "1: fixed: nothing can move, so it stands as it is, reached from the start" in out
    assert "neutral" not in out
    code, out, _ = run("modes", "truss.lag")
    assert (code, out.strip()) == (0, "Truss: modes about a.phi = 0, b.phi = 2.094395: none, nothing can move")


def test_columns_of_matrices_stay_apart(run: Lag) -> None:
    """1.00012-0.000123456 was two columns of twelve characters."""
    Path("soft.lag").write_text("model Soft Block a(m = 1, base = world), b(m = 1, base = world); Spring left(k = 1, "
                                "stretch = a.s), right(k = 1, stretch = b.s), between(k = 0.000123456, stretch = b.s - a.s); "
                                "end Soft;")
    code, out, _ = run("linearize", "soft.lag")
    assert code == 0
    assert [[*map(float, line.split()[1:])] for line in out.partition("\nK\n")[2].splitlines()[1:3]] == [
        [1.00012, -0.000123456], [-0.000123456, 1.00012]]
