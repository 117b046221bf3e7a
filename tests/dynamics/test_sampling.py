"""Values held between instants, `when sample(start, interval) then ...`, against exact discretisation: runs, FMUs, studies."""

import math
from pathlib import Path

import fmpy
import numpy as np
import pytest
from scipy.linalg import expm

import lagrangia as lag
from helpers.fmus import KINDS, VERSIONS, unpacked
from lagrangia.command.cli import main

PID = """model Pid
  parameter Real K = 40; parameter Real Ki = 30; parameter Real Kd = 8; parameter Time Ts = 0.05; parameter Time late = {late};
  input Force w;
  Block cart(m = 2, base = world);
  Damper drag(rate = cart.v, c = 0.5);
  Spring s(stretch = cart.s, k = 3);
  Real e(start = 0); Real i(start = 0); Force u(start = 0); Force applied(start = 0);
  AppliedForce f(at = cart.center, force = {{applied + w, 0}});
equation
  when sample(0, Ts) then
    u = 1[N]*(K*e + Ki*i + Kd*(e - pre(e))*1[s]/Ts);
    i = pre(i) + Ts*e/1[s];
    e = 1 - cart.s/1[m];
  end when;
  when sample(late, Ts) then
    applied = u;
  end when;
end Pid;"""
A, B = np.array([[0, 1], [-1.5, -0.25]]), np.array([[0], [0.5]])


def model(folder: Path, late: str = "0", **options: object) -> lag.Model:
    (folder / "scene.lag").write_text(PID.format(late=late))
    return lag.load(folder / "scene.lag", **options)


def flow(t: float) -> tuple[np.ndarray, np.ndarray]:
    E = expm(np.block([[A, B], [np.zeros((1, 3))]]) * t)
    return E[:2, :2], E[:2, 2]


def exact(stop: float, late: float = 0.0, Ts: float = 0.05, w: float = 0.0) -> np.ndarray:
    """s, s', u at a time that is an instant, before it."""
    x, e, i, u, applied = np.zeros(2), 0.0, 0.0, 0.0, 0.0
    for _ in range(round(stop / Ts)):
        before, e = e, 1 - x[0]
        i += Ts * e
        u = 40 * e + 30 * i + 8 * (e - before) / Ts
        if late:
            F, G = flow(late)
            x = F @ x + G * (applied + w)
        applied = u
        F, G = flow(Ts - late)
        x = F @ x + G * (applied + w)
    return np.array([*x, u])


@pytest.mark.parametrize("solver", ["auto", "erk9", "taylor", "implicit", "adams", "linear", "pirk"])
def test_a_sampled_pid_is_its_exact_discretisation(solver: str, tmp_path: Path) -> None:
    run = model(tmp_path).simulate(stop=3, tolerance=1e-12, solver=solver)
    assert [run["cart.s"][-1], run["cart.v"][-1]] == pytest.approx(exact(3)[:2], abs=1e-12)
    assert run.statistics.events == 59
    assert run.statistics.energy_residual < 1e-10


def test_what_is_computed_late_acts_late(tmp_path: Path) -> None:
    """Two samplers; parameters say when, and inputs act beside."""
    run = model(tmp_path, "0.02").simulate(stop=3, tolerance=1e-12, inputs={"w": 0.7})
    assert [run["cart.s"][-1], run["cart.v"][-1]] == pytest.approx(exact(3, 0.02, w=0.7)[:2], abs=1e-12)
    run = model(tmp_path, "0.02").simulate(stop=3, tolerance=1e-12, parameters={"Ts": 0.1, "late": 0.06})
    assert [run["cart.s"][-1], run["cart.v"][-1]] == pytest.approx(exact(3, 0.06, 0.1)[:2], abs=1e-12)


def test_held_values_in_rows(tmp_path: Path) -> None:
    """A row at an instant has what was held before it, one behind it what is held from there on."""
    run = model(tmp_path).simulate(at=[0.0, 0.049, 0.05, 0.0500001, 2.0], stop=2, tolerance=1e-12)
    first = 40 + 30 * 0.05 + 8 / 0.05
    assert run["u"][[0, 1, 2, 4]] == pytest.approx([first, first, first, exact(2)[2]], abs=1e-9)
    assert run["u"][3] == pytest.approx(exact(0.1)[2])
    assert run["f.force"][:, 0] == pytest.approx(run["applied"])


def test_instants_before_and_after_the_start(tmp_path: Path) -> None:
    """None before the first one; a run that begins between two takes the next ones alone."""
    text = """model M
      Block b(m = 1, base = world);
      Real n(start = 3); Real at(start = -1);
    equation
      when sample(0.25, 0.5) then n = pre(n) + 1; at = time/1[s]; end when;
    end M;"""
    (tmp_path / "scene.lag").write_text(text)
    scene = lag.load(tmp_path / "scene.lag")
    run = scene.simulate(at=[0.1, 0.3, 0.8, 1.3], stop=2)
    assert run["n"].tolist() == [3, 4, 5, 6]
    assert run["at"].tolist() == [-1, 0.25, 0.75, 1.25]
    run = scene.simulate(start=0.6, at=[0.7, 0.8], stop=2)
    assert run["n"].tolist() == [4, 5]  # the value of the instant at 0.25 holds, taken at the start


def test_a_million_instants_are_where_they_should_be(tmp_path: Path) -> None:
    (tmp_path / "scene.lag").write_text("""model M
      Block b(m = 1, base = world);
      Real n(start = 0);
    equation
      when sample(0, 0.001) then n = pre(n) + 1; end when;
    end M;""")
    run = lag.load(tmp_path / "scene.lag").simulate(stop=100, at=[50.0005, 99.9995])
    assert run["n"].tolist() == [50001, 100000]


def test_sweeps_and_steps(tmp_path: Path) -> None:
    scene = model(tmp_path, "0.02")
    found = scene.simulate_many(parameters={"K": [10.0, 40.0]}, outputs=["final(cart.s)", "max(u)"], stop=3, tolerance=1e-12)
    assert found["final(cart.s)"][1] == pytest.approx(exact(3, 0.02)[0], abs=1e-12)
    run = scene.start(tolerance=1e-12)
    for _ in range(10):
        run.step(0.07)
    kept = run.save()
    there = [run.step(0.1).copy() for _ in range(23)]
    assert there[-1][:2] == pytest.approx(exact(3, 0.02)[:2], abs=1e-11)
    run.restore(kept)
    assert [run.step(0.1).tolist() for _ in range(23)] == [x.tolist() for x in there]


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("kind", KINDS)
def test_fmus(version: str, kind: str, tmp_path_factory: pytest.TempPathFactory) -> None:
    folder = tmp_path_factory.mktemp("fmu")
    model(folder, "0.02")
    run = fmpy.simulate_fmu(str(unpacked(folder / "scene.lag", version)), fmi_type=kind, stop_time=3, step_size=0.03,
                            output_interval=0.03, relative_tolerance=1e-9, output=["cart.s", "u"])
    assert run["cart.s"][-1] == pytest.approx(exact(3, 0.02)[0], abs=1e-12 if kind == "CoSimulation" else 1e-6)


def test_the_sampled_system(tmp_path: Path) -> None:
    """z, e, i, u, applied from instant to instant."""
    for late in (0.0, 0.02):
        linear = model(tmp_path, str(late)).linearize()
        sampled = linear.sampled
        assert sampled is not None
        assert sampled.states == ("cart.s", "der(cart.s)", "u", "i", "e", "applied")
        order = [0, 1, *(sampled.states.index(name) for name in ("e", "i", "u", "applied"))]
        first = np.eye(7)
        first[2, [0, 2]] = -1, 0
        first[3] += 0.05 * first[2]
        first[4] = 40 * first[2] + 30 * first[3] + 8 / 0.05 * first[2]
        first[4, 2] -= 8 / 0.05
        second = np.eye(7)
        second[5] = second[4]

        def over(t: float) -> np.ndarray:
            F, G = flow(t)
            found = np.eye(7)
            found[:2, :2], found[:2, 5], found[:2, 6] = F, G, G
            return found

        whole = over(0.05 - late) @ second @ over(late) @ first
        assert sampled.A[np.ix_(order, order)] == pytest.approx(whole[:6, :6], abs=1e-12)
        assert sampled.B[order, 0] == pytest.approx(whole[:6, 6], abs=1e-12)
        assert (sampled.interval, sampled.inputs) == (0.05, ("w",))
        assert linear.B[1, linear.inputs.index("applied")] == 0.5
        assert "u = 0, not 201.5" in linear.notes[0]


def test_difference_equations_alone(tmp_path: Path) -> None:
    """Fibonacci's numbers, and a value that reads the new one of another."""
    (tmp_path / "scene.lag").write_text("""model M
      Block b(m = 1, base = world);
      Real n(start = 1); Real before(start = 0); Real twice(start = 0);
    equation
      when sample(1, 1) then before = pre(n); n = pre(n) + pre(before); end when;
      when sample(2, 2) then twice = 2*n; end when;
    end M;""")
    run = lag.load(tmp_path / "scene.lag").simulate(stop=10, at=[k + 0.5 for k in range(10)])
    assert run["n"].tolist() == [1, 1, 2, 3, 5, 8, 13, 21, 34, 55]
    assert run["twice"].tolist() == [0, 0, 4, 4, 10, 10, 26, 26, 68, 68]


def test_conditions_on_held_values_and_states(tmp_path: Path) -> None:
    """A relay that is sampled: u = 1 N below 1 m, else -1 N; and a filter of what is held."""
    (tmp_path / "scene.lag").write_text("""model M
      Block b(m = 1, base = world);
      Force u(start = 0); Force z(start = 0);
      AppliedForce f(at = b.center, force = {u, 0});
    equation
      der(z) = (u - z)/0.3[s];
      when sample(0, 0.1) then u = if b.s < 1[m] then 1 else -1; end when;
    end M;""")
    run = lag.load(tmp_path / "scene.lag").simulate(stop=4, tolerance=1e-12)
    s, v, z = 0.0, 0.0, 0.0
    for _ in range(40):
        u = 1.0 if s < 1 else -1.0
        s, v, z = s + 0.1 * v + 0.005 * u, v + 0.1 * u, u + (z - u) * math.exp(-0.1 / 0.3)
    assert [run["b.s"][-1], run["b.v"][-1], run["z"][-1]] == pytest.approx([s, v, z], abs=1e-11)


@pytest.mark.parametrize(("clause", "what"), [
    ("when sample(0, 0.1) then v = u; u = v; end when;", "L0212"),
    ("when sample(0, 0) then u = 1; v = 1; end when;", "L0605"),
    ("when sample(0, b.s/1[m]*1[s]) then u = 1; v = 1; end when;", "L0232"),
    ("when sample(0, 0.1) then u = 1; end when; when sample(0, 0.2) then u = 2; v = 1; end when;", "L0232"),
    ("when sample(0, 0.1) then u = der(b.v)/1[m/s2]; v = 1; end when;", "L0901"),
    ("when sample(0, 0.1) then b.s = 1; u = 1; v = 1; end when;", "L0232"),
    ("when sample(0, 0.1) then reinit(b.v, 0); end when; u = 1; v = 1;", "L0222"),
    ("when sample(0) then u = 1; v = 1; end when;", "L0215"),
    ("when b.s > 1[m] and sample(0, 1) then reinit(b.v, 0); end when; u = 1; v = 1;", "L0215"),
    ("when sample(0[m], 0.1) then u = 1; v = 1; end when;", "L0304"),
    ("when sample(0, 0.1) then u = b.s; v = 1; end when;", "L0304"),
    ("when sample(0, 0.1) then end when; u = 1; v = 1;", "L0222"),
])
def test_what_is_wrong(clause: str, what: str, tmp_path: Path) -> None:
    (tmp_path / "scene.lag").write_text(f"""model M
      Block b(m = 1, base = world);
      Real u(unit = "1", start = 0); Real v(unit = "1", start = 0);
      AppliedForce f(at = b.center, force = {{u*1[N], v*1[N]}});
    equation
      {clause}
    end M;""")
    with pytest.raises(lag.LagError, match=what):
        lag.load(tmp_path / "scene.lag")


def test_what_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    scene = model(tmp_path)
    for target in ("python", "casadi", "modelica", "sympy", "latex"):
        assert main(f"export scene.lag --to {target} -o out.x".split()) == 2
        assert "not supported yet" in capsys.readouterr().err
    with pytest.raises(lag.LagError, match="not supported yet: values that are held between instants, with CasADi"):
        scene.simulate(solver="casadi:cvodes")
    with pytest.raises(lag.LagError, match="not supported yet: written equations of a scene with values that are held"):
        scene.equations()
    with pytest.raises(lag.RunError, match=r"the interval of the sampled values at .* must be positive, and is 0 s"):
        scene.simulate(parameters={"Ts": 0.0})
    with pytest.raises(lag.LagError, match="held value 'u' in the place of a frame"):
        (tmp_path / "place.lag").write_text("""model M
          Length u(start = 0);
          Frame f = shift(world, {u, 0}); PointMass p(m = 1, center = f);
        equation
          when sample(0, 1) then u = 1; end when;
        end M;""")
        lag.load(tmp_path / "place.lag")


def test_the_library(tmp_path: Path) -> None:
    """SampledPID is what is written by hand, within its limits; Hold takes u at its instants."""
    (tmp_path / "scene.lag").write_text("""model M
      Block cart(m = 2, base = world);
      SampledPID c(k = 40, Ts = 0.05, Ti = 4/3, Td = 0.2, set = 1, u = cart.s/1[m], low = -30, high = 30, late = 0.01);
      Hold h(Ts = 0.3, first = 0.1, u = cart.s/1[m]);
      AppliedForce f(at = cart.center, force = {c.y*1[N], 0});
    end M;""")
    run = lag.load(tmp_path / "scene.lag").simulate(stop=4, at=[0.1, 0.39, 0.4, 0.45, 4], tolerance=1e-12)
    s, v, y, sum_, error = 0.0, 0.0, 0.0, 0.0, 0.0
    for _ in range(80):
        before, error = error, 1 - s
        wanted = 40 * (error + sum_ + 0.0375 * error + 4 * (error - before))
        computed = max(-30.0, min(30.0, wanted))
        sum_ += 0.0375 * error if computed == wanted else 0.0
        for h, force in ((0.01, y), (0.04, computed)):
            s, v = s + h * v + h * h / 4 * force, v + h / 2 * force
        y = computed
    assert [run["cart.s"][-1], run["cart.v"][-1], run["c.I"][-1]] == pytest.approx([s, v, sum_], abs=1e-11)
    assert run["h.y"][:4] == pytest.approx([0, *run["cart.s"][[0, 0, 2]]], abs=1e-12)  # a row at an instant is before it


def drawn(seed: int, count: int, S: float, Ts: float) -> np.ndarray:
    """Whole numbers as L'Ecuyer (1988) has them, and Box and Muller's cosine."""
    m1, m2, found = 2147483563, 2147483399, []
    b, d = 1000003 + 1619 * seed, 2000029 + 4871 * seed
    for _ in range(4):
        b, d = 40014 * b % m1, 40692 * d % m2
    for _ in range(count):
        a, c = 40014 * b % m1, 40692 * d % m2
        b, d = 40014 * a % m1, 40692 * c % m2
        u, v = ((1 + x % (m1 - 1)) / m1 for x in (a - c, b - d))
        found.append(math.sqrt(S / (2 * Ts) * -2 * math.log(u)) * math.cos(2 * math.pi * v))
    return np.array(found)


def test_white_noise(tmp_path: Path) -> None:
    """Number by number; its variance is S/(2 Ts), it repeats itself in sweeps, and another seed is another noise."""
    (tmp_path / "scene.lag").write_text("""model M
      Block cart(m = 2, base = world);
      WhiteNoise n(S = 4, Ts = 0.01);
      AppliedForce f(at = cart.center, force = {n.y*1[N], 0});
    end M;""")
    scene, count = lag.load(tmp_path / "scene.lag"), 20_000
    y = scene.simulate(stop=count * 0.01, at=[0.01 * k + 0.005 for k in range(count)])["n.y"]
    assert y == pytest.approx(drawn(1, count, 4, 0.01), abs=1e-11)
    assert y.var() == pytest.approx(4 / 0.02, rel=0.02)
    assert abs(np.corrcoef(y[1:], y[:-1])[0, 1]) < 0.02
    found = scene.simulate_many(parameters={"n.seed": [1.0, 2.0]}, outputs=["final(cart.v)"], stop=2)["final(cart.v)"]
    for seed, v in zip((1, 2), found, strict=True):
        assert v == pytest.approx(0.005 * drawn(seed, 200, 4, 0.01).sum(), abs=1e-9)
