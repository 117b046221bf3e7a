"""The Python interface: lag.load(...) -> Model, model.simulate(...) -> Trajectory."""

import os
import warnings
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

from lagrangia.base import checked_values as checked
from lagrangia.base.diagnostics import EngineWarning, Interrupted, RunError, fail
from lagrangia.run.cache import find_scene, keep_scene
from lagrangia.run.engines import Engine, divided, load_engine
from lagrangia.run.formulas import AS_DECLARED, Compute, Formulas, Sets, by_masses, by_numbers, by_varied
from lagrangia.run.interpret import evaluate
from lagrangia.run.library import Runtime, find_runtime, has_compiler, has_runtime
from lagrangia.run.origin import Origin, origin_of
from lagrangia.run.prepared import PreparedRun
from lagrangia.run.remarks import warn_of_given, warn_of_loss, warn_of_vain
from lagrangia.run.request import Request, Values, check_values, plan
from lagrangia.run.scene import Column, Scene
from lagrangia.run.simulate import simulate
from lagrangia.run.solvers import AUTO, WAYS, is_casadi
from lagrangia.run.stepped import SteppedRun
from lagrangia.study.analysed import REACTION, Analysed
from lagrangia.study.swept import Swept
from lagrangia.view.rows import collect
from lagrangia.view.sight import Shown, Sight, known_column
from lagrangia.view.trajectory import Trajectory

if TYPE_CHECKING:
    import casadi
    import numpy as np

    from lagrangia.compile.pipeline import Compilation
    from lagrangia.paper.pages import Page
    from lagrangia.study.analysis import Study
    from lagrangia.study.controlled import Controller

Given = Mapping[str, float] | None
NO_COMPILER = ("no run time came with the package, and no C compiler was found to make one: CasADi's cvodes is used, which is "
               "slower and less accurate (pip install ziglang brings a compiler)")


def load(path: str | os.PathLike[str], *, model: str | None = None, **structural: Any) -> "Model":
    """Compile the last model of a `.lag` file, or the one named `model`.

    Keyword arguments give structural parameters (Integer, Boolean, constants): lag.load("chain.lag", n=20); a dotted name goes in
    a dictionary, lag.load("x.lag", **{"left.n": 3}). Raises LagError when the file is wrong.
    """
    return Model(path, model, structural)


def loads(text: str, *, model: str | None = None, **structural: Any) -> "Model":
    """As `load`, from the text itself, which imports no other files. Raises LagError when it is wrong."""
    from lagrangia.language.loose_text import place_of

    return Model(place_of(text), model, structural)


def _animate(run: Trajectory, path: str | os.PathLike[str] | None, **asked: Any) -> str:
    from lagrangia.solids.showing import animate_any

    return animate_any(run, path, **asked)


class Model(Analysed, Swept):
    """A compiled scene. Parameters are numbers of each run: changing one compiles nothing."""

    def __init__(self, path: str | os.PathLike[str] | Origin, model: str | None = None, structural: Any = None,
                 outputs: Sequence[str] = (), formulas: Formulas = AS_DECLARED) -> None:
        """`formulas` hold for some values of the parameters: see `suited`."""
        self.formulas, self._others = formulas, dict[Formulas, Model]()
        self._reporting = dict[tuple[Any, ...], Model]()  # the latest, by engine and names
        self.origin, self.model = origin_of(path), model if model is None else checked.a_text("name of the model", model)
        self.structural = dict(checked.by_name("structural parameters", structural))
        self.outputs = checked.names("outputs", outputs)
        self._compilation: Compilation | None = None
        self._engine: Engine | None = None
        self._has_engine = False
        self._engines: dict[str, Engine | None] = {}  # of solvers that want one of their own
        self.native: bool | None = None  # native code, a tape, or what costs less time
        found = find_scene(self.origin.unchanged(), model, self.structural, self.outputs, self.formulas)
        self.is_cached = found is not None
        self._runtime: Runtime | None = None if self.is_cached else find_runtime()
        self.scene: Scene = found if found is not None else self._keep(self.compilation.scene)

    def _keep(self, scene: Scene, others: Sequence[str] | None = None) -> Scene:
        """`others` are the files that were read for it, but those of tables."""
        read = [Path(name) for name in (*(self.compilation.flat.read if others is None else others), *scene.notes["files"])]
        keep_scene(scene, self.path, self.model, self.structural, self.outputs, read, self.formulas)
        return scene

    @property
    def freedom(self) -> Mapping[str, Any]:
        """Degrees of freedom, redundant constraints, what cannot close and how else loops can: see freedom.freedom_notes.

        A run does not need it, so that it is found when it is first asked for, and then kept with the scene.
        """
        if self.scene.notes["freedom"] is None:
            from lagrangia.dynamics.freedom import find_freedom, freedom_notes

            c = self.compilation
            found = freedom_notes(find_freedom(c.kinematics, c.motion, c.constraints, c.initial, c.functions.table))
            self.scene = self._keep(replace(self.scene, notes={**self.scene.notes, "freedom": found}))
        notes: Mapping[str, Any] = self.scene.notes["freedom"]
        return notes

    @property
    def readers(self) -> Mapping[str, list[str]]:
        """What reads the parameters that only other parameters and starts read; of large scenes found when first asked for."""
        if self.scene.notes["readers"] is None:
            from lagrangia.compile.pipeline import flatten_file
            from lagrangia.language.parameter_readers import find_readers

            made = self._compilation
            flat = made.flat if made is not None else flatten_file(self.origin.unchanged(), self.model, self.structural)[1]
            self.scene = self._keep(replace(self.scene, notes={**self.scene.notes, "readers": find_readers(flat)}), flat.read)
        found: Mapping[str, list[str]] = self.scene.notes["readers"]
        return found

    @property
    def warnings(self) -> list[str]:
        """What the model says in vain, in words: parameters and ports that are given and read by nothing."""
        return list(self.scene.notes["warnings"])

    @property
    def compilation(self) -> "Compilation":
        """What each phase of the compiler made; compiled when first asked for."""
        if self._compilation is None:
            from lagrangia.compile.pipeline import compile_file

            self._compilation = compile_file(self.origin.unchanged(), self.model, self.structural, self.outputs, self.formulas)
        return self._compilation

    def completed(self) -> "Model":
        """Itself, with what implicit and conservative steps need, which large scenes get when it is first asked for."""
        if self.scene.sizes.get("jacobian_waits"):
            from lagrangia.compile.pipeline import with_what_waits

            self._compilation = with_what_waits(self.compilation, self.outputs)
            self.scene, self._has_engine = self._keep(self._compilation.scene), False
        return self

    @property
    def engine(self) -> Engine | None:
        """The run time with the scene in it, or None when there is neither a run time nor a C compiler."""
        if not self._has_engine:
            self._engine, self._has_engine = load_engine(self.scene, self._runtime, self.native), True
        return self._engine

    @property
    def name(self) -> str:
        """The model's name."""
        return self.scene.name

    def simulate(self, *, stop: float | None = None, start: float | None = None, tolerance: float | None = None,
                 interval: float | None = None, at: Sequence[float] | None = None, parameters: Given = None,
                 initial: Given = None, inputs: Any = None, solver: str = "auto", max_step: float = 0.0,
                 max_steps: int = 0, controllers: "Mapping[str, Controller] | None" = None, every: float = 0.0,
                 from_: "str | Mapping[str, float] | None" = None) -> Trajectory:
        """Integrate from `start` to `stop` (s); rows every `interval`, or at the times `at`.

        `tolerance` is relative to the size of each coordinate and rate. `parameters` and `initial` map names to values in SI
        units; `inputs` maps names to constants, or is a pair (times, {name: values}) of tables that are linear in between.
        `solver` is "auto", a name from solvers.WAYS, or an integrator of CasADi as "casadi:cvodes". `controllers` maps inputs to
        functions f(t, run) -> value, asked `every` so many seconds, where rows are then; run["x"] is the present (SteppedRun).
        `from_`: "equilibrium" begins at rest, {"hinge.w": 12} in steady motion with these rates, reached from `initial`.
        Raises LagError for wrong input, RunError (with what was computed in `.trajectory`) when the run cannot go on, Interrupted
        (with it in `.result`) after Ctrl-C. A RunWarning tells of an open energy account, an EngineWarning that CasADi runs for
        want of a C compiler, InputWarnings of inputs without values, tables that end before the run, and parameters in vain.
        """
        request = Request(start, stop, tolerance, interval, at, solver, max_step, max_steps, parameters, initial, inputs)
        by_input = checked.by_name("controllers", controllers)
        warn_of_given(self, request, later=by_input)
        if from_ is not None:
            from lagrangia.study.steady_start import begun

            found = begun(self, from_, parameters, initial, inputs, plan(self.scene, request).start)
            request = replace(request, initial=found.values)
        if controllers is not None or every:
            from lagrangia.study.controlled import simulate_controlled

            return simulate_controlled(self, request, by_input, every)
        return self.run(request)

    def start(self, *, parameters: Given = None, initial: Given = None, inputs: Given = None, start: float | None = None,
              tolerance: float | None = None, solver: str = "auto", max_step: float = 0.0) -> SteppedRun:
        """A run that the caller makes step by step, setting inputs on the way. Raises LagError, RunError."""
        warn_of_vain(self, parameters)
        experiment = plan(self.scene, Request(start, tolerance=tolerance, solver=solver, max_step=max_step))
        suited = self.fitting(parameters).completed()
        values = check_values(suited.scene, parameters, initial, inputs)
        if (engine := suited.engine_for(experiment.solver)) is None:
            fail("L0901", "not supported yet: runs in steps without a run time of our own: call simulate")
        return SteppedRun(suited.scene, engine, experiment, values)

    def run(self, request: Request) -> Trajectory:
        """What `simulate` does, by a request."""
        import numpy as np

        experiment = plan(self.scene, request)
        suited = self.fitting(request.parameters)
        values = check_values(suited.scene, request.parameters, request.initial, request.inputs)
        if suited.falls_back(experiment.solver):
            warnings.warn(NO_COMPILER, EngineWarning, stacklevel=3)
        progress, portions = suited.launch(experiment, values)
        kept, failure = list[Sequence[float]](), None
        try:
            kept.extend(portions)
        except RunError as error:
            failure = error
        except KeyboardInterrupt:  # between two portions
            progress.interrupted = True
        trajectory = Trajectory(suited.scene, collect(suited.scene, kept), progress,
                                suited.observer(np.array(progress.parameters), values), Shown(suited, values, request, _animate),
                                suited.sight(values))
        if failure is not None:
            failure.trajectory = trajectory
            raise failure
        if progress.interrupted:
            raise Interrupted.with_result(trajectory, f"at t = {progress.time:.6g}")
        warn_of_loss(progress)
        return trajectory

    def prepare(self, initial: Given = None, parameters: Given = None, **asked: Any) -> PreparedRun:
        """A run for many calls, run([q, ...], [p, ...]), by values of all that `initial` and `parameters` name, in this order.
        All else is `asked` for once, as of `simulate`. Raises LagError, RunError."""
        request = Request(**asked)
        warn_of_given(self, replace(request, initial=initial, parameters=parameters))
        experiment = plan(self.scene, request)
        suited = (self._for_all_of(parameters) if parameters else self).completed()
        values = check_values(suited.scene, parameters, initial, asked.get("inputs"))
        if (engine := suited.engine_for(experiment.solver)) is None:
            fail("L0901", "not supported yet: prepared runs without a run time of our own: call simulate")
        uneven = replace(suited.formulas, for_any_mass=True)
        return PreparedRun(suited.scene, engine, experiment, values, tuple(initial or ()), tuple(parameters or ()),
                           lambda: ((other := suited._in(uneven).completed()).scene, other.engine_for(experiment.solver)))

    def _for_all_of(self, varied: Collection[str]) -> "Model":
        """The model whose formulas hold whatever the values of these parameters, in a large scene as long as masses are even."""
        parameters = [p for p in self.scene.parameters if p.name in varied]
        if any(self.scene.parameters[k] in parameters for k in self.scene.notes["touching"]["parameters"]):
            fail("L0901", "not supported yet: prepared runs over parameters by which constraints only just hold: call simulate")
        is_open = any(p.compiled is not None and (p in parameters or p.value is None) for p in self.scene.parameters)
        model = self.general if is_open else self
        return model._in(by_varied(model.scene, model.formulas, varied))

    def fitting(self, parameters: Given) -> "Model":
        """This model, or the same scene in the formulas that these parameters need: it may have other coordinates."""
        return self.suited(check_values(self.scene, parameters)) if checked.by_name("parameters", parameters) else self

    def suited(self, values: Values) -> "Model":
        """The same for checked values."""
        declared = check_values(self.scene)
        if (values.parameters, values.mask) == (declared.parameters, declared.mask):
            return self
        return self._suited(lambda: [(values.parameters, values.mask)], evaluate)

    def _suited(self, sets: Sets, compute: Compute, is_open: bool = False) -> "Model":
        """`is_open`: numbers that are compiled in are not looked at, as none is."""
        formulas = self.formulas if is_open else by_numbers(self.scene, self.formulas, sets, compute)
        if formulas == self.formulas:
            formulas = by_masses(self.scene, formulas, sets, compute)
        return self if formulas == self.formulas else self._in(formulas)._suited(sets, compute, is_open)

    @property
    def general(self) -> "Model":
        """The scene with all its parameters open: no number is compiled in."""
        has_numbers = any(p.compiled is not None and not p.locked for p in self.scene.parameters)
        return self._in(replace(self.formulas, is_general=True, massless=None)) if has_numbers else self

    def opened(self, parameters: Given, where: str) -> "Model":
        """In formulas that hold whatever `where` ("an FMU") sets, from these parameters on. Raises LagError L0704."""
        values = check_values(self.scene, parameters)
        suited = self.general._suited(lambda: [(values.parameters, values.mask)], evaluate, is_open=True)
        told = suited.scene.notes["balanced"]
        if unknown := [name for name in self.suited(values).scene.notes["balanced"] if name not in told]:
            fail("L0704", f"the coordinate '{unknown[0]}' moves no mass while parameters are as declared, and {where} lets them "
                 "change", None, "write `final` before these, as PointMass knot(final m = 0), Prismatic p(final along = {1, 0})")
        return suited.completed()

    def sharing_reactions(self, length: float = 1.0) -> "Model":
        """The same, reactions that the mechanics leave open by least squares, torques over this length (m)."""
        return self._in(replace(self.formulas, least_squares=checked.a_length(length)))

    def telling_reactions(self, names: Sequence[str] = (REACTION,)) -> "Model":
        """The same, or where reactions are among these quantities and a scene in space lies in a plane, the scene in space."""
        return self.in_space if any(REACTION in name for name in checked.names("quantities", names)) else self

    @property
    def in_space(self) -> "Model":
        """The same, or where a scene in space lies in a plane, the scene in space, as it is written on paper."""
        return self._in(replace(self.formulas, in_space=True)) if self.compilation.graph.lies_in_plane else self

    def _in(self, formulas: Formulas) -> "Model":
        if formulas not in (self.formulas, *self._others):
            self._others[formulas] = self._with(self.outputs, formulas)
        return self._others.get(formulas, self)

    def reporting(self, names: Sequence[str]) -> "Model":
        """This model, or one that reports these names too, of which the latest is kept."""
        known = {column.name for column in self.scene.outputs}
        missing = tuple(name for name in names if name not in known and self.scene.slot(name) is None)
        if not missing:
            return self
        asked = self.native, missing
        if asked not in self._reporting:
            self._reporting = {asked: self._with((*self.outputs, *missing), self.formulas)}
        return self._reporting[asked]

    def _with(self, outputs: Sequence[str], formulas: Formulas) -> "Model":
        other = Model(self.origin, self.model, self.structural, outputs, formulas)
        other.native = self.native
        return other

    def launch(self, experiment: Any, values: Any, watch: Any = None) -> Any:
        """A run's progress and the iterator over its rows; see simulate.simulate."""
        engine = self.engine_for(experiment.solver)
        if engine is None:
            self.falls_back(experiment.solver)
            from lagrangia.study.casadi_solvers import simulate_casadi

            return simulate_casadi(self.compilation, experiment, values, watch)
        return simulate(self.scene, engine, experiment, values, watch, lambda: self.completed().engine)

    def falls_back(self, solver: str) -> bool:
        """Whether CasADi takes the place of our own solver, as there is neither a run time nor a C compiler.

        Raises LagError L0704 where a solver or an engine was asked for by name: another one is not what was asked for.
        """
        if is_casadi(solver) or self.engine_for(solver) is not None:
            return False
        if solver != AUTO or self.native is not None:
            self._refuse(solver, "casadi:cvodes")
        return True

    def _refuse(self, solver: str, other: str) -> NoReturn:
        """A solver or an engine for want of a C compiler. Raises LagError L0704."""
        engine = {True: "engine 'native'", False: "engine 'tape'", None: ""}[self.native]
        what = f"solver '{solver}'" if solver != AUTO else engine
        fail("L0704", f"the {what} needs a C compiler, and none that works was found", None,
             f"pip install ziglang brings one; without one, choose auto or {other}")

    def engine_for(self, solver: str) -> Engine | None:
        """The engine that runs a solver of this name. Raises LagError L0704 where engine 'tape' cannot."""
        if is_casadi(solver):
            return None
        if solver in ("implicit", "conservative"):
            self.completed()
        if solver == "islands" and self.engine is not None:
            self._engine = divided(self.engine, self.scene, self.native)
        if self.native and not self._has_engine and has_runtime() and not has_compiler():
            self._refuse(solver, "--engine tape")
        if solver == "implicit" and solver not in self._engines:
            self._engines[solver] = load_engine(self.scene, self._runtime, self.native, WAYS[solver].number)
        return self._engines[solver] if solver == "implicit" else self.engine

    def observer(self, parameters: "np.ndarray", values: Any) -> Any:
        """Computes any quantity from rows of results."""
        return partial(self._observe, parameters, values)

    def _observe(self, parameters: "np.ndarray", values: Values, name: str, rows: "np.ndarray", start: float) -> "np.ndarray":
        from lagrangia.study.observing import observe

        return observe(self.scene, self.compilation, parameters, values, name, rows, start)

    def sight(self, values: Values) -> Sight:
        """What pictures of a run with these values ask of the model."""
        return Sight(self._columns_of, partial(self._small_run, values))

    def _columns_of(self, name: str) -> tuple[Column, ...]:
        from lagrangia.compile.scenes import columns_of

        known = known_column(self.scene, name)
        return (known,) if known is not None else columns_of(self.compilation.kinematics, name)

    def _small_run(self, values: Values, rows: "np.ndarray", names: Sequence[str]) -> "dict[str, np.ndarray]":
        from lagrangia.study.small_run import small_run

        return small_run(self.compilation, values, rows, names)

    def __reduce__(self) -> "tuple[Any, ...]":
        """Pickled as what it was loaded from: where it is unpickled, in whatever folder, the file must be there as it was."""
        return Model, (self.origin, self.model, self.structural, self.outputs, self.formulas)

    def study(self, parameters: Given = None, initial: Given = None, inputs: Any = None, time: float | None = None) -> "Study":
        """What small motion and rest are found of, with these numbers, at one time (s). Raises LagError."""
        from lagrangia.study.analysis import Study

        warn_of_vain(self, parameters, initial)
        suited = self.fitting(parameters)
        return Study(suited.compilation, check_values(suited.scene, parameters, initial, inputs), time)

    def equations(self, form: str = "lagrange", format: str = "text", *, names: Mapping[str, str] | None = None,
                  parameters: Given = None, numbers: bool = False, force: bool = False, language: str = "en") -> "Page":
        """The equations of motion for people, as `lag equations` prints them: a text, which notebooks show typeset. `names` maps
        names of the model to symbols, {"tilt.phi": "theta"}; with `numbers` the values of the parameters are put in. Raises
        LagError for an unknown form, format, name or language."""
        from lagrangia.paper.sheet import Request, write_equations

        symbols, given = checked.by_name("symbols", names), checked.by_name("parameters", parameters)
        request = Request(form, format, symbols, dict(given), numbers, force, language=language)
        return write_equations(self.origin.unchanged(), request, self.model, self.structural)

    def draw(self, path: str | os.PathLike[str] | None = None, *, at: float | None = None, names: Mapping[str, str] | None = None,
             parameters: Given = None, initial: Given = None, inputs: Any = None, view: tuple[float, float] | None = None) -> str:
        """The scene as a textbook draws it, at the start or at the time `at` (s): an SVG's text; a path (.svg, .pdf, .png) is
        written as well. `names` maps names of the model to symbols, {"tilt.phi": "theta"}; `view` is the azimuth and elevation,
        degrees, from where a scene in space is seen. Raises LagError, RunError."""
        from lagrangia.solids.showing import draw_any

        request = Request(at=None if at is None else [at], parameters=parameters, initial=initial, inputs=inputs)
        return draw_any(self, path, request, checked.by_name("symbols", names), view=view)

    def _repr_html_(self) -> str:
        return self.draw()

    def export_fmu(self, path: str | os.PathLike[str] | None = None, *, fmi: str | int = "2", kind: str = "me,cs",
                   platforms: str = "host", sources: bool = True, parameters: Given = None, info: Mapping[str, str] | None = None,
                   engine: str = "auto", arrays: bool = True, tell: Callable[[str], None] | None = None) -> "list[Path]":
        """Write an FMU, at `path` or into that folder; returns the files, two for fmi="both", whose names get the version.

        `fmi` is "2", "3" or "both", `kind` "me", "cs" or "me,cs", `platforms` "host", "all" or names (fmu_build.PLATFORMS).
        `parameters` are other start values of the FMU's parameters, in SI units; `info` may give author, version, copyright and
        license; `engine`: this machine's binary runs the tape ("tape"), is compiled ("native"), or what costs less ("auto").
        Without `arrays` FMI 3 has scalars in their place. What takes long is told to `tell`. Raises LagError.
        """
        from lagrangia.fmu.export import export_fmus

        suited = self.opened(parameters, "an FMU")
        warn_of_vain(self, parameters)
        return export_fmus(suited, path, fmi, kind, platforms, sources, parameters, info, engine, arrays, tell)

    def functions(self, *, given: str | Iterable[str] = ()) -> "dict[str, casadi.Function]":
        """CasADi Functions of t, q, v, u, p: M, h, rhs, energies, outputs, jacobian.

        q, u, p and the outputs are in the order of `position_names`, `input_names`, `parameter_names` and `output_names`.
        What is bound to other parameters follows them: its entry of p is not read, and derivatives with respect to the others go
        through its binding. `given` are names of such that p gives all the same (a mapping will do: functions(given=changes) with
        parameter_values(changes)). Constrained scenes have Phi, J, bias and lambda too; see functions.people_functions.
        Raises LagError L0701, L0702 for names that are none.
        """
        from lagrangia.compile.people_functions import people_functions

        c, known = self.general.compilation, self._known_parameters(given)
        return people_functions(c.kinematics, c.motion, c.constraints, self.output_names, known)

    def derivatives(self, *, given: str | Iterable[str] = ()) -> "dict[str, casadi.Function]":
        """CasADi Functions that go with those of `functions`: jacobian_u and jacobian_p of t, q, v, u, p are d(dv/dt)/du and
        d(dv/dt)/dp, with what follows from p; parameters of p are the values of all parameters. Raises LagError L0701, L0702.

        Where loops repeat equations, what follows an axis of a hinge that lies along another one is NaN in jacobian_p."""
        from lagrangia.compile.people_functions import people_derivatives

        c, known = self.general.compilation, self._known_parameters(given)
        has_repeated = c.motion.constrained is not None and bool(self.general.freedom["repeated"])
        return people_derivatives(c.kinematics, c.motion, known, has_repeated)

    def _known_parameters(self, given: str | Iterable[str]) -> tuple[str, ...]:
        check_values(self.scene, dict.fromkeys(known := checked.names("given parameters", given), 0.0))
        return known

    @cached_property
    def coordinate_names(self) -> tuple[str, ...]:
        """In the order of q."""
        return tuple(column.name for column in self.scene.coordinates)

    @cached_property
    def position_names(self) -> tuple[str, ...]:
        """In the order of q of `functions`: unit quaternions of attitudes, which are three coordinates each."""
        return tuple(column.name for column in self.scene.told_positions)

    @cached_property
    def input_names(self) -> tuple[str, ...]:
        """In the order of u."""
        return tuple(item.name for item in self.scene.inputs)

    @cached_property
    def output_names(self) -> tuple[str, ...]:
        """Outputs that are declared or asked for."""
        return tuple(column.name for column in self.scene.outputs)

    @cached_property
    def parameter_names(self) -> tuple[str, ...]:
        """Scalar parameters in the order of p."""
        return tuple(parameter.name for parameter in self.scene.parameters)

    def parameter_values(self, parameters: Given = None) -> "np.ndarray":
        """All parameters, (n_parameters,), in SI units, with those given changed and the dependent ones following."""
        import numpy as np

        values = check_values(self.scene, parameters)
        return np.array(self.compilation.functions.table["parameters"](values.parameters, values.mask)).ravel()

    def __repr__(self) -> str:
        return f"<{self.name}: {', '.join(self.coordinate_names[:6])}{', ...' if self.scene.n > 6 else ''}>"
