"""Momenta that no force changes: of coordinates that the accelerations let be, and of attitudes about axes of what carries them
or about their own. By rates at random states, as what vanishes by sin^2 + cos^2 = 1 does so nowhere in the text."""

import casadi as ca
import numpy as np

from lagrangia.algebra.duals import Scalar, dot
from lagrangia.algebra.scalars import as_expression
from lagrangia.constraints.parameters import default_parameters
from lagrangia.dynamics.motion import Motion
from lagrangia.frames.attitudes import matrix_of, present
from lagrangia.frames.kinematics import Kinematics
from lagrangia.language.attitudes import parts_of

_ROUNDING = 1e-9  # of what the largest acceleration would give
_LOOKS = 2


def constant_momenta(kinematics: Kinematics, motion: Motion, given: ca.DM | None = None) -> list[str]:
    """In words, of a tree without constraints, whose accelerations hold at any state; between its events. With the parameters as
    declared, or `given`."""
    found = _momenta(kinematics, motion)
    if not found:
        return []
    words, momenta = zip(*found, strict=True)
    p = ca.vertcat(*momenta)
    rate = ca.jtimes(p, motion.q, motion.pace) + ca.jtimes(p, motion.v, motion.acceleration) + ca.jtimes(p, motion.t, ca.SX(1))
    parts = [rate, ca.jacobian(p, motion.v), motion.acceleration]
    _, declared = default_parameters(kinematics)
    references = [mode.symbol for mode in kinematics.algebra.modes if mode.of_attitude]
    known = [(motion.p, ca.SX(declared if given is None else given)),
             (ca.vertcat(motion.impacts.forces, motion.impacts.impulses), None),
             (ca.vertcat(ca.SX(0, 1), *references), ca.SX([0 if k % 4 else 1 for k in range(len(references))]))]
    for symbols, value in known:
        if symbols.numel():
            parts = ca.substitute(parts, [symbols], [ca.SX.zeros(symbols.numel()) if value is None else value])
    symbols = ca.vertcat(ca.SX(0, 1), *ca.symvar(ca.veccat(*parts)))
    look, numbers = ca.Function("look", [symbols], parts), np.random.default_rng(5)
    looks = [[x.full() for x in look(numbers.uniform(0.3, 1.7, symbols.numel()))] for _ in range(_LOOKS)]
    changing = np.array([np.abs(rate).ravel() > _ROUNDING * np.abs(M).sum(axis=1) * np.abs(a).max() for rate, M, a in looks])
    return [word for word, changes in zip(words, changing.T, strict=True) if not changes.any()]


def _momenta(kinematics: Kinematics, motion: Motion) -> list[tuple[str, Scalar]]:
    """All that may be constant."""
    own = dict(zip(kinematics.symbols.positions, ca.vertsplit(motion.momentum), strict=True))
    turned = {part for name in kinematics.symbols.attitudes for part in parts_of(name)}
    found: list[tuple[str, Scalar]] = [(f"of '{name}'", p) for name, p in own.items() if name not in turned]
    for name, reference in kinematics.symbols.attitudes.items():
        parts = parts_of(name)
        momentum = tuple(own[part] for part in parts)
        outward = matrix_of(present(reference, tuple(kinematics.symbols.positions[part] for part in parts)))
        found += [(f"of '{name}' about the {axis} axis of what carries it", as_expression(dot(row, momentum)))
                  for axis, row in zip("xyz", outward, strict=True)]
        found += [(f"of '{name}' about its own {axis} axis", p) for axis, p in zip("xyz", momentum, strict=True)]
    return found
