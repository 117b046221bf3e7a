"""Exudyn on scenes of space.py, of rigid bodies and joints by its generalised-alpha method with fixed steps, which follow from a
tolerance by its second order; the top as three hinges, too, with Dormand-Prince 5(4), and the arm's tree (space_peers.py)."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

Array = np.ndarray
Case = tuple[Callable[[], Any], Callable[[], float]]  # a run, and how far it ended from what is known


def _system() -> tuple[Any, Any]:
    import exudyn

    exudyn.config.printToConsole = False
    container = exudyn.SystemContainer()
    return container, container.AddSystem()


def _run(container: Any, system: Any, stop: float, steps: int, error: Callable[[Any], float], explicit: float = 0,
         way: str = "EXUdense") -> Case:
    """`explicit`: the tolerance of Dormand-Prince 5(4) instead of steps; `way`: of linear equations."""
    import exudyn

    system.Assemble()
    settings = exudyn.SimulationSettings()
    time = settings.timeIntegration
    time.adaptiveStep = False  # none shorter where Newton does not converge
    time.numberOfSteps, time.verboseMode, time.endTime = steps, 0, stop
    time.generalizedAlpha.spectralRadius = 0.9
    time.newton.relativeTolerance, time.newton.absoluteTolerance = 1e-8, 1e-9
    settings.linearSolverType = getattr(exudyn.LinearSolverType, way)
    settings.linearSolverSettings.ignoreSingularJacobian = way == "EigenDense"  # a loop's equations repeat others
    settings.solution.file.write = settings.show.computationTime = False
    settings.solution.sensors.writePeriod = 1e9
    method = exudyn.DynamicSolverType.GeneralizedAlpha
    if explicit:
        method, time.automaticStepSize, time.minimumStepSize = exudyn.DynamicSolverType.DOPRI5, True, 1e-14
        time.relativeTolerance = time.absoluteTolerance = explicit

    def run(_: Any = container) -> None:  # which must not end before the run does
        if not system.SolveDynamic(settings, solverType=method):
            raise ArithmeticError("Exudyn gave up")

    return run, lambda: error(system)


def _body(system: Any, mass: float, inertia: Sequence[float], centre: Array, turn: Array, v: Array, w: Array,
          g: Sequence[float]) -> Any:
    """`centre`, `v` and the rate `w` in the world; `inertia` about own axes."""
    from exudyn.utilities import RigidBodyInertia

    return system.CreateRigidBody(referencePosition=list(centre), referenceRotationMatrix=turn, initialVelocity=list(v),
                                  initialAngularVelocity=list(w), gravity=list(g),
                                  inertia=RigidBodyInertia(mass=mass, inertiaTensor=np.diag(inertia)))


def _place(system: Any, body: int, local: Sequence[float]) -> Array:
    import exudyn

    return np.array(system.GetObjectOutputBody(body, exudyn.OutputVariableType.Position, list(local)))


def _turned(sine: float, cosine: float, known: float) -> float:
    return float(abs((np.arctan2(sine, cosine) - known + np.pi) % (2 * np.pi) - np.pi))


def top(steps: int, centre: Array) -> Case:
    container, system = _system()
    turn = Rotation.from_rotvec([0.5, 0, 0]).as_matrix()
    w = turn @ [0, 0, 200.0]
    body = _body(system, 0.5, (0.002, 0.002, 0.001), turn @ [0, 0, 0.1], turn, np.zeros(3), w, (0, 0, -9.81))
    ground = system.CreateGround()
    system.CreateSphericalJoint(bodyNumbers=[ground, body], position=[0, 0, 0])
    return _run(container, system, 2, steps, lambda system: float(np.abs(_place(system, body, (0, 0, 0)) - centre).max() / 0.1))


def top_of_hinges(tolerance: float, centre: Array) -> Case:
    import exudyn
    from exudyn.itemInterface import NodeGenericODE2, ObjectKinematicTree

    container, system = _system()
    node = system.AddNode(NodeGenericODE2(referenceCoordinates=[0.0] * 3, initialCoordinates=[0, 0.5, 0],
                                          initialCoordinates_t=[0, 0, 200.0], numberOfODE2Coordinates=3))
    joint = exudyn.JointType
    system.AddObject(ObjectKinematicTree(
        nodeNumber=node, gravity=[0.0, 0.0, -9.81], jointTypes=[joint.RevoluteZ, joint.RevoluteX, joint.RevoluteZ],
        linkParents=[-1, 0, 1], linkMasses=[0.0, 0.0, 0.5], jointTransformations=exudyn.Matrix3DList([np.eye(3)] * 3),
        jointOffsets=exudyn.Vector3DList([[0.0] * 3] * 3), linkCOMs=exudyn.Vector3DList([[0.0] * 3, [0.0] * 3, [0, 0, 0.1]]),
        linkInertiasCOM=exudyn.Matrix3DList([np.zeros((3, 3)), np.zeros((3, 3)), np.diag([0.002, 0.002, 0.001])])))

    def error(system: Any) -> float:
        phi, theta, _ = system.systemData.GetODE2Coordinates(configuration=exudyn.ConfigurationType.Current)
        axis = [np.sin(phi) * np.sin(theta), -np.cos(phi) * np.sin(theta), np.cos(theta)]
        return float(np.abs(axis - 10 * centre).max())

    return _run(container, system, 2, 200, error, tolerance)


def bars(steps: int, n: int, inertia: Sequence[float], known: Array) -> Case:
    container, system = _system()
    before, place, v, L = system.CreateGround(), np.zeros(3), np.zeros(3), 1 / n
    for k in range(1, n + 1):
        turn = Rotation.from_rotvec([0, 0, 1.2 * k / n]).as_matrix()
        w, along = turn @ [10.0, 0, 0], turn @ [L, 0, 0]
        body = _body(system, L, inertia, place + along / 2, turn, v + np.cross(w, along / 2), w, (0, 0, -9.81))
        system.CreateSphericalJoint(bodyNumbers=[before, body], position=list(place))
        before, place, v = body, place + along, v + np.cross(w, along)

    def error(system: Any) -> float:
        return float(np.abs(_place(system, before, (L / 2, 0, 0)) - known).max())

    return _run(container, system, 1, steps, error, way="EigenSparse")


def bricard(steps: int, known: float) -> Case:
    container, system = _system()
    ground = before = system.CreateGround()
    ways = ((1, 0, 0), (0, -1, 0), (0, 0, 1), (-1, 0, 0), (0, 1, 0))
    axes, place, first, still = ((0, 1, 0), (0, 0, 1), (1, 0, 0), (0, 1, 0), (0, 0, 1)), np.zeros(3), None, np.zeros(3)
    for way, axis in zip(ways, axes, strict=True):
        inertia = [(1.01 - 0.99 * x * x) / 12 for x in way]
        body = _body(system, 1.0, inertia, place + np.array(way) / 2, np.eye(3), still, still, (0, -9.81, 0))
        system.CreateRevoluteJoint(bodyNumbers=[before, body], position=list(place), axis=list(axis), useGlobalFrame=True)
        before, place, first = body, place + way, body if first is None else first
    system.CreateRevoluteJoint(bodyNumbers=[before, ground], position=list(place), axis=[1, 0, 0], useGlobalFrame=True)

    def error(system: Any) -> float:
        x, _, z = _place(system, first, (0.5, 0, 0))
        return _turned(-z, x, known)

    return _run(container, system, 2, steps, error, way="EigenDense")


def rssr(steps: int, known: float) -> Case:
    container, system = _system()
    ground, g = system.CreateGround(), (0, 0, -9.81)
    w, w2, D = np.array([0, 0, 8.0]), np.array([0, 3.2781501882489182, 0]), np.array([0.9, 0.5, 0.2])
    back = Rotation.from_rotvec([0, -1.6258742567362116, 0]).as_matrix()
    A, B = np.array([0.3, 0, 0]), D + back @ [0.6, 0, 0]
    crank = _body(system, 1.0, (0.001, 0.02, 0.02), A / 2, np.eye(3), np.cross(w, A / 2), w, g)
    rocker = _body(system, 1.5, (0.001, 0.05, 0.05), (B + D) / 2, back, np.cross(w2, B - D) / 2, w2, g)
    rates, along = (np.cross(w, A), np.cross(w2, B - D)), (B - A) / 1.1
    turn = Rotation.align_vectors([along], [[1.0, 0, 0]])[0].as_matrix()
    rod = _body(system, 2.0, (0.002, 0.2, 0.2), (A + B) / 2, turn, sum(rates) / 2, np.cross(along, rates[1] - rates[0]) / 1.1, g)
    system.CreateRevoluteJoint(bodyNumbers=[ground, crank], position=[0, 0, 0], axis=[0, 0, 1], useGlobalFrame=True)
    system.CreateRevoluteJoint(bodyNumbers=[ground, rocker], position=list(D), axis=[0, 1, 0], useGlobalFrame=True)
    system.CreateSphericalJoint(bodyNumbers=[crank, rod], position=list(A))
    system.CreateSphericalJoint(bodyNumbers=[rod, rocker], position=list(B))

    def error(system: Any) -> float:
        x, y, _ = _place(system, crank, (0.15, 0, 0))
        return _turned(y, x, known)

    return _run(container, system, 2, steps, error)
