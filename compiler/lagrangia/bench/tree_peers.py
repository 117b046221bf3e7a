"""Peers for the accelerations of trees of rigid bodies: Pinocchio's ABA and MuJoCo's forward dynamics, called from Python.

Each gets the same joints in numbers, the weight, and what else acts on the coordinates, in numbers too.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from importlib.metadata import PackageNotFoundError, version
from typing import TYPE_CHECKING, Any

import numpy as np

from lagrangia.base.attitude_values import quaternion_of
from lagrangia.base.records import dataclass
from lagrangia.dynamics.spatial_axes import SpatialJoint

if TYPE_CHECKING:
    from numpy.typing import NDArray

_NAMES = {"pinocchio": "pin", "mujoco": "mujoco"}
_STILL = 1e-15  # kg or kg.m2: MuJoCo wants more of all that moves
_LARGEST_WHOLE = 200  # rates: all that Pinocchio makes room for takes 32 n^3 bytes


class Unfit(Exception):
    """The peer cannot represent the tree, with the reason."""


@dataclass(frozen=True)
class Tree:
    """Joints in numbers, parents first, at one state; of each turn and shift one coordinate that its amount is, of a ball joint
    three, s and the angular velocity in the axes behind it."""

    joints: Sequence[SpatialJoint]
    size: int
    positions: "NDArray[np.float64]"  # (n,)
    rates: "NDArray[np.float64]"
    gravity: "NDArray[np.float64]"  # (3,), m/s2
    forces: "NDArray[np.float64]"  # (n,), of springs, dampers and loads on the coordinates


@dataclass(frozen=True)
class Peer:
    """What is timed, and what it gives."""

    name: str
    accelerations: Callable[[], "NDArray[np.float64]"]  # (n,)
    call: Callable[[], object]


def peers_of(tree: Tree) -> Iterator[Peer | tuple[str, str]]:
    """Those that can take it; a name and the reason of each other."""
    for name, make in (("pinocchio", _pinocchio), ("mujoco", _mujoco)):
        try:
            version(_NAMES[name])
            yield make(tree)
        except PackageNotFoundError:
            yield name, f"not installed: pip install {_NAMES[name]}"
        except Unfit as reason:
            yield name, str(reason)


def _require_known(joint: SpatialJoint) -> None:
    if len(joint.coordinates) != (3 if joint.kind == "rotation" else 1):
        raise Unfit("only hinges, sliders and ball joints that coordinates move are given to peers")


def _positions(tree: Tree, joint: SpatialJoint) -> tuple[float, ...]:
    """As peers have them: of a ball joint its quaternion, the real part first."""
    at = tree.positions[[*joint.coordinates]].tolist()
    return quaternion_of(at) if joint.kind == "rotation" else tuple(at)


# -------------------------------------------------------------------- Pinocchio


def _pinocchio_model(tree: Tree) -> tuple[Any, "NDArray[np.float64]", list[int]]:
    """The model, its positions, and where each of its rates stands among ours."""
    import pinocchio as pin

    model, ids = pin.Model(), list[int]()
    model.gravity.linear = tree.gravity
    for k, joint in enumerate(tree.joints):
        _require_known(joint)
        if joint.kind == "rotation":
            made = pin.JointModelSpherical()
        elif joint.kind == "turn":
            made = pin.JointModelRevoluteUnaligned(np.array(joint.axis, float))
        else:
            made = pin.JointModelPrismaticUnaligned(np.array(joint.slopes[0], float))
        parent = ids[joint.parent] if joint.parent is not None else 0
        ids.append(model.addJoint(parent, made, pin.SE3(np.array(joint.R, float), np.array(joint.origin, float)), f"j{k}"))
        if joint.body is not None:
            m, center, about = _about_center(joint)
            model.appendBodyToJoint(ids[-1], pin.Inertia(m, center, about), pin.SE3.Identity())
    q, places = np.empty(model.nq), [0] * model.nv
    for joint, i in zip(tree.joints, ids, strict=True):
        at, first = _positions(tree, joint), model.joints[i]
        q[first.idx_q : first.idx_q + first.nq] = at if len(at) == 1 else (*at[1:], at[0])  # the real part last
        places[first.idx_v : first.idx_v + first.nv] = joint.coordinates
    return model, q, places


def _about_center(joint: SpatialJoint) -> "tuple[float, NDArray[np.float64], NDArray[np.float64]]":
    body = joint.body
    assert body is not None
    b, J = np.array(body.moment, float), np.array(body.second_moment, float)
    if body.mass == 0:
        return 0.0, np.zeros(3), J
    c = b / body.mass
    return float(body.mass), c, J - body.mass * (c @ c * np.eye(3) - np.outer(c, c))


def _pinocchio(tree: Tree) -> Peer:
    import pinocchio as pin

    model, q, places = _pinocchio_model(tree)
    data, v = _pinocchio_data(model), tree.rates[places]
    tau = tree.forces[places]

    def found() -> "NDArray[np.float64]":
        return _back(pin.aba(model, data, q, v, tau), places)

    return Peer("pinocchio", found, lambda: pin.aba(model, data, q, v, tau))


def _pinocchio_data(model: Any) -> Any:
    """Room for its results: all, or of a large tree what its ABA reads and writes, without tensors of second derivatives."""
    import pinocchio as pin

    if model.nv <= _LARGEST_WHOLE:
        return model.createData()
    data = pin.Data()
    _give(data, "joints", [joint.createData() for joint in model.joints])
    for name in ("liMi", "oMi"):
        _give(data, name, [pin.SE3.Identity()] * model.njoints)
    for name in ("v", "a", "a_gf"):
        _give(data, name, [pin.Motion.Zero()] * model.njoints)
    for name in ("h", "f"):
        _give(data, name, [pin.Force.Zero()] * model.njoints)
    _give(data, "Yaba", [np.zeros((6, 6))] * model.njoints)
    data.ddq = np.zeros(model.nv)
    return data


def _give(data: Any, name: str, values: Iterable[Any]) -> None:
    held = type(getattr(data, name))()
    held.extend(values)
    setattr(data, name, held)


def _back(found: "NDArray[np.float64]", places: Sequence[int]) -> "NDArray[np.float64]":
    result = np.empty(len(found))
    result[list(places)] = found
    return result


# -------------------------------------------------------------------- MuJoCo


def _mujoco(tree: Tree) -> Peer:
    import mujoco

    try:
        model = _mujoco_spec(tree).compile()
    except ValueError as error:
        raise Unfit(f"it refuses the model: {str(error).splitlines()[0]}") from None
    data, places = mujoco.MjData(model), [0] * tree.size
    for k, joint in enumerate(tree.joints):
        made, at = model.joint(f"j{k}"), _positions(tree, joint)
        data.qpos[made.qposadr[0] : made.qposadr[0] + len(at)] = at
        places[made.dofadr[0] : made.dofadr[0] + len(joint.coordinates)] = joint.coordinates
    data.qvel[:], data.qfrc_applied[:] = tree.rates[places], tree.forces[places]

    def found() -> "NDArray[np.float64]":
        mujoco.mj_forward(model, data)
        return _back(data.qacc, places)

    return Peer("mujoco", found, lambda: mujoco.mj_forward(model, data))


def _mujoco_spec(tree: Tree) -> Any:
    """Its description of the tree, made body by body: its reader of texts takes 500 within each other."""
    import mujoco

    kinds = {"turn": mujoco.mjtJoint.mjJNT_HINGE, "shift": mujoco.mjtJoint.mjJNT_SLIDE, "rotation": mujoco.mjtJoint.mjJNT_BALL}
    spec, bodies = mujoco.MjSpec(), list[Any]()
    spec.compiler.degree = spec.compiler.balanceinertia = False
    spec.option.gravity = tree.gravity
    for k, joint in enumerate(tree.joints):
        if joint.body is None or joint.body.mass < _STILL or np.linalg.eigvalsh(_about_center(joint)[2]).min() < _STILL:
            raise Unfit("it wants mass and three moments of inertia of every body that moves")
        _require_known(joint)
        m, center, J = _about_center(joint)
        quaternion = np.empty(4)
        mujoco.mju_mat2Quat(quaternion, np.array(joint.R, float).ravel())
        parent = bodies[joint.parent] if joint.parent is not None else spec.worldbody
        bodies.append(parent.add_body(pos=[float(x) for x in joint.origin], quat=quaternion, explicitinertial=True, mass=m,
                                      ipos=center, fullinertia=[J[0, 0], J[1, 1], J[2, 2], J[0, 1], J[0, 2], J[1, 2]]))
        axis = joint.slopes[0] if joint.kind == "shift" else joint.axis
        bodies[-1].add_joint(name=f"j{k}", type=kinds[joint.kind], axis=[float(x) for x in axis])
    return spec


def in_numbers(joints: Sequence[SpatialJoint], value: Callable[[Any], float]) -> list[SpatialJoint]:
    """Joints with numbers in the place of expressions of parameters. Raises Unfit."""
    found = []
    for joint in joints:
        if joint.kind == "turn" and [value(x) for x in joint.slopes] != [1.0]:
            raise Unfit("hinges that turn by more than one coordinate, or a multiple of it, are not given to peers")
        if joint.travel:
            raise Unfit("screws are not given to peers")
        body = joint.body
        if body is not None:
            J = [[value(body.second_moment[min(i, j)][max(i, j)]) for j in range(3)] for i in range(3)]
            body = replace(body, mass=value(body.mass), moment=[value(x) for x in body.moment], second_moment=J)
        slopes = joint.slopes if joint.kind != "shift" else [[value(x) for x in slope] for slope in joint.slopes]
        found.append(replace(joint, R=[[value(x) for x in row] for row in joint.R], origin=[value(x) for x in joint.origin],
                             axis=[value(x) for x in joint.axis], slopes=slopes, body=body))
    return found
