"""Blocks `if c then ... else ... end if` whose condition the motion decides: equations of if expressions."""

from collections.abc import Sequence

from lagrangia.language.instances import Scope
from lagrangia.language.names import Names
from lagrangia.language.tree import Clause, Equality, IfBlock, IfExpression

_IF = "what the motion decides is chosen by if expressions, or equations of one left side: if c then y = a; else y = b; end if;"


def chosen_of(block: IfBlock, kind: str, scope: Scope, names: Names) -> Sequence[Clause]:
    """What holds of a block in a section of this kind: one of its branches, or equations of if expressions where the motion
    decides which. Raises LagError L0210."""
    if kind != "when" and not names.is_known(block.condition, scope) and (merged := chosen_equations(block)) is not None:
        return merged
    return block.then if names.boolean(block.condition, scope, "the condition of an if block", _IF) else block.otherwise


def chosen_equations(block: IfBlock) -> list[Clause] | None:
    """y = if c then a else b for each left side y, which all branches have; None where they do not, or do something else."""
    branches = [_equations(clauses) for clauses in (block.then, block.otherwise)]
    then, otherwise = branches
    if then is None or otherwise is None or then.keys() != otherwise.keys():
        return None
    return [Equality(one.left, IfExpression(block.condition, one.right, otherwise[left].right, block.span), one.description,
                     one.span) for left, one in then.items()]


def _equations(clauses: tuple[Clause, ...]) -> dict[str, Equality] | None:
    """By their left sides, as they are written; None where there are others, or two of one left side."""
    found: dict[str, Equality] = {}
    for clause in clauses:
        inner = chosen_equations(clause) if isinstance(clause, IfBlock) else [clause]
        for one in inner or [clause]:
            left = "".join(one.left.span.text.split()) if isinstance(one, Equality) else ""
            if not isinstance(one, Equality) or left in found:
                return None
            found[left] = one
    return found
