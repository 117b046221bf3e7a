"""Exudyn: scenes of the suite built by hand with the same coordinates, integrated by its Dormand-Prince 5(4) with step control.

Chains are kinematic trees, springs and masses its points and spring-dampers, linear scenes its second-order systems of matrices.
Each stretch between two output times is a run of its own, as Exudyn interpolates no steps.
"""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np

from lagrangia.bench.peers import Prepared, Solver, Unsuitable
from lagrangia.bench.problem import Problem

Builder = Callable[[Any, Problem], None]


def prepare(build: Builder, problem: Problem, tolerance: float) -> Prepared:
    import exudyn

    exudyn.config.printToConsole = False
    container = exudyn.SystemContainer()
    system = container.AddSystem()
    build(system, problem)
    system.Assemble()
    settings = exudyn.SimulationSettings()
    time = settings.timeIntegration
    time.numberOfSteps, time.verboseMode = 1, 0
    time.automaticStepSize, time.minimumStepSize = True, 1e-14
    time.relativeTolerance, time.absoluteTolerance = tolerance, tolerance
    settings.solution.file.write = False
    settings.solution.sensors.writePeriod = 1e9
    settings.show.computationTime = False
    configuration = exudyn.ConfigurationType
    first = system.systemData.GetSystemState(configuration=configuration.Initial)
    found = np.empty((len(problem.times), problem.n))

    def begin() -> None:
        system.systemData.SetSystemState(first, configuration=configuration.Initial)

    def run(_: Any) -> Any:
        now = problem.experiment.start
        for row, target in zip(found, problem.times, strict=True):
            time.startTime, time.endTime = now, target
            if not system.SolveDynamic(settings, solverType=exudyn.DynamicSolverType.DOPRI5, updateInitialValues=True):
                raise ArithmeticError("Exudyn gave up")
            row[:] = system.systemData.GetODE2Coordinates(configuration=configuration.Current)
            now = target
        return found

    return Prepared(run, np.copy, begin)


def solver(case: str) -> Solver:
    def prepare_case(problem: Problem, tolerance: float) -> Prepared:
        if case not in SCENES:
            raise Unsuitable("its Exudyn model is not written, or needs other coordinates")
        return prepare(SCENES[case], problem, tolerance)

    return Solver("exudyn", "exudyn", prepare_case)


# -------------------------------------------------------------------- scenes


def _node(system: Any, problem: Problem) -> int:
    from exudyn.itemInterface import NodeGenericODE2

    n = problem.n
    return int(system.AddNode(NodeGenericODE2(referenceCoordinates=[0.0] * n, initialCoordinates=problem.start[:n].tolist(),
                                              initialCoordinates_t=problem.start[n:].tolist(), numberOfODE2Coordinates=n)))


def tree(links: list[tuple[float, float]], system: Any, problem: Problem, center: tuple[float, float] | None = None) -> None:
    """Uniform bars (mass, length) hinged end to end, or one point mass at `center`."""
    import exudyn
    from exudyn.itemInterface import ObjectKinematicTree

    n, flat = len(links), center is None
    exact = [np.diag([m * L**2 / 12 if flat else 0.0] * 3) for m, L in links]
    coms = [[L / 2, 0.0, 0.0] for _, L in links] if center is None else [[*center, 0.0]]
    offsets = [[0.0, 0.0, 0.0], *[[L, 0.0, 0.0] for _, L in links[:-1]]]
    system.AddObject(ObjectKinematicTree(
        nodeNumber=_node(system, problem), gravity=[0.0, -9.81, 0.0], jointTypes=[exudyn.JointType.RevoluteZ] * n,
        linkParents=list(range(-1, n - 1)), jointTransformations=exudyn.Matrix3DList([np.eye(3)] * n),
        jointOffsets=exudyn.Vector3DList(offsets), linkInertiasCOM=exudyn.Matrix3DList(exact),
        linkCOMs=exudyn.Vector3DList(coms), linkMasses=[m for m, _ in links]))


def spring_pendulum(k: float, system: Any, problem: Problem) -> None:
    from exudyn.itemInterface import (
        Force,
        MarkerNodePosition,
        NodePoint2D,
        NodePointGround,
        ObjectConnectorSpringDamper,
        ObjectMassPoint2D,
    )

    node = system.AddNode(NodePoint2D(referenceCoordinates=[0.0, 0.0], initialCoordinates=problem.start[:2].tolist(),
                                      initialVelocities=problem.start[2:].tolist()))
    system.AddObject(ObjectMassPoint2D(mass=1.0, nodeNumber=node))
    ground = system.AddNode(NodePointGround(referenceCoordinates=[0.0, 0.0, 0.0]))
    markers = [system.AddMarker(MarkerNodePosition(nodeNumber=number)) for number in (ground, node)]
    system.AddObject(ObjectConnectorSpringDamper(markerNumbers=markers, stiffness=k, damping=0.0, referenceLength=1.0))
    system.AddLoad(Force(markerNumber=markers[1], loadVector=[0.0, -9.81, 0.0]))


def matrices(M: Any, K: Any, D: Any, system: Any, problem: Problem) -> None:
    from exudyn.itemInterface import ObjectGenericODE2

    system.AddObject(ObjectGenericODE2(nodeNumbers=[_node(system, problem)], massMatrix=np.array(M, dtype=float),
                                       stiffnessMatrix=np.array(K, dtype=float), dampingMatrix=np.array(D, dtype=float)))


def row(n: int, system: Any, problem: Problem) -> None:
    """Unit masses and springs between two walls."""
    K = 2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    matrices(np.eye(n), K, np.zeros((n, n)), system, problem)


SCENES: Mapping[str, Builder] = {
    "linear 2": partial(matrices, [[2, 0], [0, 1]], [[5, -2], [-2, 3]], [[0.4, -0.1], [-0.1, 0.1]]),
    "linear 200": partial(row, 200),
    "pendulum": partial(tree, [(1.0, 1.0)], center=(0.0, -1.0)),
    "double pendulum": partial(tree, [(1.0, 1.0), (0.5, 0.7)]),
    **{f"chain {n}": partial(tree, [(1.0, 0.5)] * n) for n in (5, 20, 100)},
    "spring pendulum": partial(spring_pendulum, 3 * 9.81),
    "stiff spring pendulum": partial(spring_pendulum, 1e6),
}
