"""Numbers for what stands on pages of equations, by CasADi from the same model: energies, derivatives, forces, points."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import casadi as ca
import numpy as np
import sympy as sp

from lagrangia.algebra.scalars import as_expression
from lagrangia.base.diagnostics import LagError
from lagrangia.compile.pipeline import compile_energies
from lagrangia.dynamics.energies import Energies, evaluate_energies
from lagrangia.paper.book import Book
from lagrangia.paper.forms import component_sub
from lagrangia.paper.layout import Name
from lagrangia.paper.parts import Parts
from lagrangia.paper.typeset import line

POINTS = 20


@dataclass
class Reference:
    """Arrays of POINTS values by the text of a name."""

    values: dict[str, np.ndarray]
    residuals: list[np.ndarray]  # of each equation: M a + h + J^T lambda - f
    rates: Mapping[str, str]
    virtual: Mapping[str, str]


@cache
def _compiled(path: Path, structural: tuple[tuple[str, int], ...] = ()):
    return compile_energies(path, None, dict(structural))


def reference(path: Path, book: Book, structural: tuple[tuple[str, int], ...] = ()) -> Reference:
    """Everything at POINTS random states, lengths that start positive positive."""
    kinematics, constraints = _compiled(path, structural)
    return _Maker(kinematics, constraints, book).made()


class _Maker:
    def __init__(self, kinematics, constraints, book: Book) -> None:
        self.k, self.constraints, self.book = kinematics, constraints, book
        self.scene = book.equations.scene
        s = kinematics.symbols
        self.q, self.v, self.a = (ca.vertcat(*x.values()) for x in (s.positions, s.rates, s.accelerations))
        self.lam = ca.SX.sym("lambda", len(book.equations.rows))
        self.dq = ca.SX.sym("dq", self.q.numel())
        self.random = np.random.default_rng(11)
        self.found: dict[str, ca.SX] = {}

    def made(self) -> Reference:
        names, scene = self.book.presentation.symbols.names, self.scene
        labels = [line(names[x]) for x in scene.q]
        n = len(labels)
        pairs = [*zip(scene.q, scene.v, strict=True), *zip(scene.v, scene.a, strict=True)]
        rates = {line(names[x]): line(names[y]) for x, y in pairs}
        virtual = {label: f"δ{label}" for label in labels}
        self._energies(labels)
        self._points()
        residuals = self._residuals()
        for k, label in enumerate(labels):
            self.found[f"f_Φ,{label}"] = -self.reactions[k]
            self.flat_names(label)
        symbols = [self.q, self.v, self.a, self.lam, self.dq, self.k.symbols.time]
        whole = ca.vertcat(*map(ca.SX, self.found.values()))
        for mode in reversed(self.k.algebra.index.modes):  # which a run holds between its crossings
            whole, residuals = ca.substitute([whole, residuals], [mode.symbol], [as_expression(mode.value)])
        free = [x for x in ca.symvar(ca.vertcat(whole, residuals)) if x.name() not in
                {y.name() for s in symbols for y in ca.symvar(ca.SX(s))}]
        function = ca.Function("all", [*symbols, *free], [whole, residuals])
        rate = self.k.symbols.tau.name()
        numbers = [1.0 if x.name() == rate else self._number(x.name()) for x in free]
        rows, wrong, values = [], [], {}
        states = []
        for _ in range(POINTS):
            state = [self.random.uniform(0.2, 1.2, n), self.random.uniform(-2, 2, n), self.random.uniform(-2, 2, n),
                     self.random.uniform(-2, 2, self.lam.numel()), self.random.uniform(-1, 1, n), self.random.uniform(0.1, 0.9)]
            states.append(state)
            x, y = function(*state, *numbers)
            rows.append(x.full().ravel())
            wrong.append(y.full().ravel())
        table = np.array(rows)
        values = {name: table[:, k] for k, name in enumerate(self.found)}
        self._states(values, states, labels)
        self._symbols(values)
        return Reference(values, list(np.array(wrong).T), rates, virtual)

    def _states(self, values: dict[str, np.ndarray], states: list, labels: list[str]) -> None:
        names, scene = self.book.presentation.symbols.names, self.scene
        for k, label in enumerate(labels):
            values[label] = np.array([s[0][k] for s in states])
            values[line(names[scene.v[k]])] = np.array([s[1][k] for s in states])
            values[line(names[scene.a[k]])] = np.array([s[2][k] for s in states])
            values[f"δ{label}"] = np.array([s[4][k] for s in states])
        for k, x in enumerate(self.book.equations.multipliers):
            values[line(names[x])] = np.array([s[3][k] for s in states])
        values["t"] = np.array([s[5] for s in states])

    def _symbols(self, values: dict[str, np.ndarray]) -> None:
        """Parameters, given functions and their rates, what others give, and the lengths with names."""
        names, scene = self.book.presentation.symbols.names, self.scene
        known = {x: self.book.values[p.name] for p in scene.parameters for x in [p.symbol]}
        values |= {line(names[x]): np.full(POINTS, number) for x, number in known.items() if x in names}
        given: dict[sp.Expr, sp.Expr] = {}
        for g in scene.given:
            value = g.value
            for x in g.moving:
                given[x], value = value, value.diff(scene.t)
        for _ in range(3):
            given = {x: value.xreplace(given) for x, value in given.items()}
        for x, value in given.items():
            if x in names:
                values[line(names[x])] = self._numbers(value.xreplace(known), values)
        for name, value in scene.dependents.items():
            x = sp.Symbol(name, real=True)
            if x in names:
                values[line(names[x])] = self._numbers(value.xreplace(given).xreplace(known), values)
        for base, name in self.book.presentation.symbols.lengths.items():
            values[line(name)] = self._numbers(sp.sqrt(base).xreplace(given).xreplace(known), values)

    def _numbers(self, value: sp.Expr, values: Mapping[str, np.ndarray]) -> np.ndarray:
        names = self.book.presentation.symbols.names
        free = sorted(value.free_symbols, key=str)
        function = sp.lambdify(free, value, "numpy")
        return np.broadcast_to(np.array(function(*(values[line(names[x])] for x in free)), dtype=float), (POINTS,))

    def _number(self, label: str) -> float:
        values = self.book.values
        base, _, place = label.rpartition("_")
        element = f"{base}[{int(place) + 1}]" if place.isdigit() else label
        return values.get(label, values.get(element, 0.7))

    def _energies(self, labels: list[str]) -> None:
        e: Energies = evaluate_energies(self.k)
        parts: Parts = self.book.parts

        def total(terms) -> ca.SX:
            wanted = {id(self._mine(t.statement)) for t in terms}
            return sum((as_expression(t.value) for group in (e.kinetic, e.potential, e.dissipation) for t in group
                        if id(t.statement) in wanted), ca.SX(0))

        T, V_e, D = total(e.kinetic), total(parts.elastic), total(e.dissipation)
        sources = {id(self._mine(x.statement)) for x, _ in parts.sources}
        V_f = total(parts.weights)
        forces = {"f": ca.SX(len(labels), 1), "a": ca.SX(len(labels), 1), "d": ca.SX(len(labels), 1)}
        drags = {id(self._mine(x.statement)) for x in parts.drags}
        for load in e.loads:
            kind = "f" if id(load.statement) in sources else "d" if id(load.statement) in drags else "a"
            for F, r in zip(load.force, load.position, strict=True):
                forces[kind] += as_expression(F) * ca.gradient(as_expression(r), self.q)
        slopes = {"T": ca.gradient(T, self.q), "V_e": ca.gradient(V_e, self.q), "V_f": ca.gradient(V_f, self.q) - forces["f"]}
        momentum = ca.gradient(T, self.v)
        rates = self._along(momentum)
        D_v = ca.gradient(D, self.v)
        self.T_q, self.rates, self.D_v = slopes["T"], rates, D_v
        self.V_q = slopes["V_e"] + slopes["V_f"]
        self.forces = forces
        found = self.found
        found |= {"T": T, "V_e": V_e, "D": D}
        for k, label in enumerate(labels):
            inertial = rates[k] - slopes["T"][k]
            found |= {f"∂T/∂{label}'": momentum[k], f"d/dt ∂T/∂{label}'": rates[k], f"∂T/∂{label}": slopes["T"][k],
                      f"∂V/∂{label}": self.V_q[k], f"∂D/∂{label}'": D_v[k], f"f_in,{label}": -inertial,
                      f"f_f,{label}": forces["f"][k], f"f_a,{label}": forces["a"][k], f"f_d,{label}": forces["d"][k],
                      f"f_c,{label}": -self.V_q[k], f"f_e,{label}": -slopes["V_e"][k], f"f_nc,{label}": -D_v[k]}
        found["δW_in"] = ca.dot(slopes["T"] - rates, self.dq)
        found["δW_e"], found["δW_nc"] = ca.dot(-slopes["V_e"], self.dq), ca.dot(-D_v + forces["d"], self.dq)
        found["δW_f"] = ca.dot(-slopes["V_f"], self.dq)
        found["δW_a"] = ca.dot(forces["a"], self.dq)

    def _mine(self, statement):
        """The statement of this model in the place of one of the model that was compiled for the page."""
        theirs, mine = self.scene.kinematics.graph.model, self.k.graph.model
        for one, other in zip((*theirs.energies, *theirs.works), (*mine.energies, *mine.works), strict=True):
            if statement is one or statement is other:
                return other
        raise AssertionError(statement)

    def flat_names(self, label: str) -> None:
        """f_c,φ,O for f_c,φ_O: an index has no index of its own."""
        for kind in ("in", "f", "a", "d", "c", "e", "nc", "Φ"):
            name = f"f_{kind},{label}"
            base, _, sub = label.partition("_")
            plain = "".join(str("₀₁₂₃₄₅₆₇₈₉".index(c)) if c in "₀₁₂₃₄₅₆₇₈₉" else c for c in label)
            if plain != label:
                digits = plain[len(plain.rstrip("0123456789")):]
                self.found[f"f_{kind},{plain[: -len(digits)]},{digits}"] = self.found[name]
            if sub:
                self.found[f"f_{kind},{base},{sub}"] = self.found[name]

    def _along(self, x: ca.SX) -> ca.SX:
        found = ca.jtimes(x, self.q, self.v) + ca.jtimes(x, self.v, self.a)
        return found + ca.jtimes(x, self.k.symbols.time, ca.SX(1))

    def _residuals(self) -> ca.SX:
        total = self.rates - self.T_q + self.V_q + self.D_v - self.forces["a"] - self.forces["d"]
        rows = [ca.SX(row.value(self.k, 0)) for row in self.constraints.rows]
        for k, row in enumerate(rows):
            self.found[line(Name("Phi", str(k + 1) if len(rows) > 1 else ""))] = row
        self.reactions = ca.SX(self.q.numel(), 1)
        for k, row in enumerate(rows[: self.lam.numel()]):
            of = self.q if k < self.scene.holonomic else self.v
            self.reactions += ca.gradient(row, of) * self.lam[k]
        return total + self.reactions

    def _points(self) -> None:
        space = self.k.graph.model.space
        for name in self.k.graph.model.frames:
            try:
                numbers = self.k.frame(name, "r", 0) if space.is_spatial else self.k.pose(name, 0).place
                place = ca.vertcat(*map(as_expression, numbers))
            except LagError:  # a port that nobody uses
                continue
            rate = self._along(place)
            twice = self._along(rate)
            sub = component_sub(name.removesuffix(".center"))
            virtual = ca.jtimes(place, self.q, self.dq)
            for k, w in enumerate(self.k.frame(name, "omega", 0) if space.is_spatial else (), 1):
                self.found.setdefault(line(Name("omega", f"{sub} {k}")), as_expression(w))
            for k, label in enumerate(component.name for component in space.components):
                for marks, x in enumerate((place, rate, twice)):
                    self.found.setdefault(line(Name(label, sub, marks)), x[k])
                self.found.setdefault(line(Name(label, sub, prefix="δ")), virtual[k])

