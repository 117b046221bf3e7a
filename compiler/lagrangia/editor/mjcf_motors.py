"""Motors of MJCF that act on a joint -> inputs and their work: a force that is linear in the command, place and speed."""

from collections import Counter
from collections.abc import Mapping, Sequence

from lagrangia.editor.mjcf_reading import Joint, Vector, Written
from lagrangia.editor.robot_text import Names, number

_UNITS = {"Revolute": "Torque", "Prismatic": "Force"}
_UNSEEN = frozenset({"name", "class", "group", "joint", "gear", "ctrlrange", "ctrllimited", "forcerange", "forcelimited", "user",
                     "kp", "kv", "gainprm", "biasprm", "gaintype", "biastype", "dyntype", "ctrlclass"})


def motor_lines(motors: Sequence[Written], joints: Mapping[str, Joint], names: Names,
                left_out: Counter[str]) -> tuple[list[str], list[str]]:
    """Declarations of inputs, and statements of energy. What acts otherwise is counted in `left_out`."""
    inputs, works = [], []
    for motor in motors:
        joint = joints.get(motor.get("joint") or "")
        law = _law(motor)
        if joint is None or joint.kind not in _UNITS or law is None:
            left_out[f"<{motor.element.tag}> {motor.get('name', '')}".rstrip()] += 1
            continue
        name = names.fresh(motor.get("name") or f"{motor.get('joint')}_motor", "_motor")
        gear = motor.leading("gear", [1.0, 0.0, 0.0, 0.0, 0.0, 0.0])[0]
        gain, constant, stiffness, damping = law
        terms = [(gain * gear, name), (constant * gear, ""), (stiffness * gear * gear, joint.coordinate),
                 (damping * gear * gear, joint.rate)]
        force = " + ".join(f"{number(factor)}*{what}" if what else number(factor) for factor, what in terms if factor) or "0"
        told = _told(motor)
        kind = _UNITS[joint.kind] if motor.element.tag == "motor" and gear == gain == 1.0 else "Real"
        inputs.append(f"input {kind} {name}" + (f" \"{told}\";" if told else ";"))
        works.append(f"work {force.replace('+ -', '- ')} on {joint.coordinate};")
    return inputs, works


def _told(motor: Written) -> str:
    """The limits, which people keep to."""
    parts = []
    for what, limited, span in (("command", "ctrllimited", "ctrlrange"), ("force", "forcelimited", "forcerange")):
        if motor.get(limited, "auto") != "false" and motor.get(span) is not None:
            lower, upper = motor.numbers(span, 2)
            parts.append(f"{what} from {number(lower)} to {number(upper)}")
    return "; ".join(parts)


def _law(motor: Written) -> Vector | None:
    """Factors of the command, of 1, of the place and of the speed; None where the force follows another law."""
    kind, kv = motor.element.tag, motor.number("kv")
    if any(name not in _UNSEEN for name in motor.attributes):
        return None
    if kind == "motor":
        return [1.0, 0.0, 0.0, 0.0]
    if kind == "position":
        kp = motor.number("kp", 1.0)
        return [kp, 0.0, -kp, -kv]
    if kind == "velocity":
        kv = motor.number("kv", 1.0)
        return [kv, 0.0, 0.0, -kv]
    if kind == "general" and motor.get("gaintype", "fixed") == "fixed" and motor.get("dyntype", "none") == "none":
        gain = motor.leading("gainprm", [1.0])[0]
        if motor.get("biastype", "none") == "none":
            return [gain, 0.0, 0.0, 0.0]
        if motor.get("biastype") == "affine":
            return [gain, *motor.leading("biasprm", [0.0, 0.0, 0.0])[:3]]
    return None
