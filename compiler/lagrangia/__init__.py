"""Lagrangia: a Modelica-style language for mechanics, with a compiler.

    import lagrangia as lag
    model = lag.load("chain.lag", n=20)
    run = model.simulate(stop=5, tolerance=1e-10, parameters={"link[1].m": 2.0})
    run.time, run["hinge[1].phi"], run.energy.total
"""

from lagrangia.base.diagnostics import Diagnostic, EngineWarning, Interrupted, LagError, RunError
from lagrangia.base.version import VERSION
from lagrangia.model import Model, load
from lagrangia.view.trajectory import EnergyAccount, Trajectory

__version__ = VERSION
__all__ = ["Diagnostic", "EnergyAccount", "EngineWarning", "Interrupted", "LagError", "Model", "RunError", "Trajectory", "load"]
