"""Blocks `if c then ... else ... end if` whose condition the motion decides: equations of if expressions."""

from collections.abc import Sequence
from dataclasses import replace

from lagrangia.language.instances import Scope
from lagrangia.language.names import Names
from lagrangia.language.tree import Clause, Equality, Expression, ForBlock, IfBlock, IfExpression, Iterator

_IF = "what the motion decides is chosen by if expressions, or equations of one left side: if c then y = a; else y = b; end if;"


def chosen_of(block: IfBlock, kind: str, scope: Scope, names: Names) -> Sequence[Clause]:
    """What holds of a block in a section of this kind: one of its branches, or equations of if expressions where the motion
    decides which. Raises LagError L0210."""
    if not names.is_known(block.condition, scope) and (merged := chosen_equations(block)) is not None:
        return merged
    return block.then if names.boolean(block.condition, scope, "the condition of an if block", _IF) else block.otherwise


def chosen_equations(block: IfBlock) -> list[Clause] | None:
    """y = if c then a else b for each y that is a side of one equation in each branch, also in loops over the same; None where
    branches have others, or do something else."""
    branches = [[one for clause in clauses for one in _plain(clause)] for clauses in (block.then, block.otherwise)]
    return _merged(block, *branches)


def _plain(clause: Clause) -> Sequence[Clause]:
    return (chosen_equations(clause) if isinstance(clause, IfBlock) else None) or [clause]


def _merged(block: IfBlock, then: Sequence[Clause], otherwise: Sequence[Clause]) -> list[Clause] | None:
    """Each clause of one branch with the only one of the other that it goes together with."""
    found, left = list[Clause](), list(otherwise)
    for one in then:
        pairs = [(other, pair) for other in left if (pair := _pair(block, one, other)) is not None]
        alike = [(other, pair) for other, pair in pairs if _sides(one)[:1] == _sides(other)[:1]]
        if len(alike or pairs) != 1:
            return None
        (other, pair), = alike or pairs
        left.remove(other)
        found.append(pair)
    return None if left else found


def _pair(block: IfBlock, one: Clause, other: Clause) -> Clause | None:
    if isinstance(one, ForBlock) and isinstance(other, ForBlock):
        same = [_text(x) for x in one.iterators] == [_text(x) for x in other.iterators]
        branches = ([x for clause in loop.body for x in _plain(clause)] for loop in (one, other))
        body = _merged(block, *branches) if same else None
        return None if body is None else replace(one, body=tuple(body))
    if not (isinstance(one, Equality) and isinstance(other, Equality)):
        return None
    for k, side in enumerate(_sides(one)):
        if side in _sides(other):
            at = _sides(other).index(side)
            value = IfExpression(block.condition, (one.right, one.left)[k], (other.right, other.left)[at], block.span)
            return Equality((one.left, one.right)[k], value, one.description, one.span)
    return None


def _sides(clause: Clause) -> list[str]:
    return [_text(clause.left), _text(clause.right)] if isinstance(clause, Equality) else []


def _text(node: Expression | Iterator) -> str:
    """As it is written."""
    return "".join(node.span.text.split())
