"""elsewhen: an event of its own, that has to exclude the one before to mean what it does in Modelica."""

from lagrangia.base.diagnostics import Report
from lagrangia.language.events import COMPARED, are_alike, parts_of, without_not
from lagrangia.language.folding import fold
from lagrangia.language.tree import Binary, Flat, WhenBlock


def warn_of_both(first: Flat, other: Flat, block: WhenBlock, report: Report, *, is_kept: bool) -> None:
    """Where the conditions of a `when` and of its elsewhen may come true at one instant, of which the first alone happens, unless
    the second resets what moves, too; where they do so always, the second never happens, which is an error."""
    span = block.condition.span
    if are_alike(first, other):
        report.error("L0225", "this never happens: the condition is that of the branch before", span, "leave the branch out")
    elif not is_kept and not come_apart(first, other):
        report.warning("L0237", "where this and the condition before come true at one instant, both happen", span,
                       "in Modelica the first one alone does; conditions that exclude each other, as x > 1 and x < -1, are safe")


def come_apart(a: Flat, b: Flat) -> bool:
    """Whether two conditions cannot come true at one instant: they exclude or deny each other. n >= 2 and n <= 2 do not, though n
    may stay on 2, for it gets there from one side; beside others, as n >= 2 and n <= 2 both in one condition, they may."""
    a, b = without_not(a), without_not(b)
    are_alone = next(parts_of(a)) is a and next(parts_of(b)) is b
    return exclude(a, b, stays=not are_alone) or are_alike(a, without_not(b, False))


def exclude(a: Flat, b: Flat, stays: bool = False) -> bool:
    """Whether two conditions cannot be true at once: one number is above what another condition keeps it below. x >= 2 and x <= 2
    are true at an instant alone, unless x `stays` there."""
    return any(_fight(x, y, stays) for x in parts_of(without_not(a)) for y in parts_of(without_not(b)))


def _fight(a: Flat, b: Flat, stays: bool) -> bool:
    if not (isinstance(a, Binary) and isinstance(b, Binary) and a.operator in COMPARED and b.operator in COMPARED):
        return False
    is_met = stays and "=" in a.operator and "=" in b.operator
    for (small, large), (low, high) in ((_sides(a), _sides(b)), (_sides(b), _sides(a))):
        if are_alike(small, high):  # x < large, x > low
            least, most = fold(low), fold(large)
            is_beyond = least is not None and most is not None and (least > most if is_met else least >= most)
            if is_beyond or (not is_met and are_alike(low, large)):
                return True
    return False


def _sides(node: Binary[Flat]) -> tuple[Flat, Flat]:
    return (node.left, node.right) if node.operator.startswith("<") else (node.right, node.left)
