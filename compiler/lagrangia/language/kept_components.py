"""Components of a scene that is flattened again after a change of its text: those that did not change are not made again.

A component follows from its declaration, which a text that is being written keeps (editor/live_text.py), its class, and what
is asked of values outside while it is made. Those that ask nothing are kept, with the instance of the scene that they lie in,
as long as all other classes are the same.
"""

from lagrangia.base.diagnostics import LIBRARY
from lagrangia.base.records import dataclass
from lagrangia.language.alike_elements import First, can_be_copied
from lagrangia.language.attributes import is_literal
from lagrangia.language.classes import ClassTable
from lagrangia.language.frame_attributes import Space
from lagrangia.language.functions import DIMENSIONS
from lagrangia.language.instances import Bound, Instance, Member, Scope, StructuralValues
from lagrangia.language.kept_visits import KeptVisits
from lagrangia.language.tree import Array, Binary, Boolean, ClassDefinition, Declaration, Expression, Number, Reference, Unary


@dataclass(frozen=True)
class _Kept:
    declaration: Declaration
    sizes: tuple[int, ...]
    member: Member
    count: int  # of components in it


class KeptScene:
    """Of a scene, as one in the plane and as one in space."""

    def __init__(self) -> None:
        self.spaces: dict[bool, KeptComponents] = {}

    def within(self, space: Space) -> "KeptComponents":
        """What is kept of it as one in this space."""
        return self.spaces.setdefault(space.is_spatial, KeptComponents())


class KeptComponents:
    """Of the last scene that was flattened with these."""

    def __init__(self) -> None:
        self.space: Space | None = None
        self.table: ClassTable | None = None
        self.files = 0  # in it, when the scene was begun
        self.others: list[ClassDefinition] = []
        self.root: Instance | None = None
        self.last: dict[int, _Kept] = {}  # by the ids of declarations
        self.now: dict[int, _Kept] = {}
        self.declared: dict[int, Declaration] = {}  # by the ids of components
        self.visits = KeptVisits()
        self.own: frozenset[int] = frozenset()  # the ids of the scene's own declarations: no other class modifies them

    def begin(self, table: ClassTable, root: Instance, space: Space) -> Instance:
        """A scene is flattened: what it lies in from now on."""
        classes = (c for file in table.files.values() for c in file.classes) if table.files else table.user.values()
        others = [c for c in classes if c is not root.definition]
        is_same = (space is self.space and len(others) == len(self.others) and all(map(lambda a, b: a is b, others, self.others))
                   and self._has_means_of_its_own())
        self.space, self.others, self.last, self.now = space, others, self.now if is_same else {}, {}
        self.declared = {}
        if not is_same:
            self.visits = KeptVisits()
        self.table, self.files = table, len(table.files)
        self.own = frozenset(map(id, root.definition.elements))
        if self.root is None or not is_same:
            self.root = root
        else:
            self.root.__dict__ |= root.__dict__
        return self.root

    def _has_means_of_its_own(self) -> bool:
        """Whether the last scene named no class but the library's, those of its files, and all as they are written there."""
        if self.table is None or not self.table.files:
            return True
        taken = list(self.table.files)[self.files :]
        return not self.table.scopes.copies and all(source.name.startswith(LIBRARY) for source in taken)

    def found(self, declaration: Declaration, sizes: tuple[int, ...]) -> _Kept | None:
        """What was made of a declaration."""
        kept = self.last.get(id(declaration))
        if kept is None or kept.declaration is not declaration or kept.sizes != sizes:
            return None
        self._keep(kept)
        return kept

    def keep(self, declaration: Declaration, sizes: tuple[int, ...], member: Member, count: int) -> None:
        """For the next time, if it names no component around it."""
        if id(declaration) in self.own and can_be_copied(member, First(1)):
            self._keep(_Kept(declaration, sizes, member, count))

    def _keep(self, kept: _Kept) -> None:
        self.now[id(kept.declaration)] = kept
        self.declared[id(kept.member)] = kept.declaration


class Asked(StructuralValues):
    """Values, and whether one was asked for that is not written where it is asked."""

    def __init__(self, values: StructuralValues) -> None:
        self.values, self.space, self.any = values, values.space, False

    def integer(self, expression: Expression, scope: Scope, what: str, hint: str = "") -> int:
        """The integer that an expression must be. Raises LagError L0210."""
        self.any |= not (isinstance(expression, Number) or _are_dimensions(expression, scope.instance))
        return self.values.integer(expression, scope, what, hint)

    def boolean(self, expression: Expression, scope: Scope, what: str, *hints: str) -> bool:
        """The truth value that an expression must be. Raises LagError L0210."""
        self.any |= not isinstance(expression, Boolean)
        return self.values.boolean(expression, scope, what, *hints)

    def shape(self, bound: Bound) -> tuple[int, ...]:
        """The sizes of what is bound. Raises LagError."""
        is_own = bound.scope.instance.parent is not None and _is_arithmetic(bound.expression)
        self.any |= bool(bound.selection) or not (is_own or is_literal(bound.expression))
        return self.values.shape(bound)

    def known(self, bound: Bound) -> Expression | None:
        """The value of what is bound, where it is known when the scene is compiled. Raises LagError."""
        self.any = True
        return self.values.known(bound)

    def begin(self, root: Instance) -> None:
        """Names are looked up in an instance whose members are being made."""
        self.any = True
        self.values.begin(root)

    def count_of_literals(self, node: Reference) -> int | None:
        """How many values an enumeration has; None for what is none."""
        self.any |= not _are_dimensions(node)
        return self.values.count_of_literals(node)


def _are_dimensions(node: Expression, instance: Instance | None = None) -> bool:
    """Whether it is how many the space has."""
    is_name = isinstance(node, Reference) and [(part.name, part.subscripts) for part in node.parts] == [(DIMENSIONS, ())]
    return is_name and (instance is None or DIMENSIONS not in instance.members)


def _is_arithmetic(node: Expression) -> bool:
    """Whether its shape follows from those of the variables that it names, whatever their values."""
    match node:
        case Reference(parts, _):
            return not any(part.subscripts for part in parts)
        case Array(items, _):
            return all(map(_is_arithmetic, items))
        case Unary(_, operand, _):
            return _is_arithmetic(operand)
        case Binary(_, left, right, _):
            return _is_arithmetic(left) and _is_arithmetic(right)
    return isinstance(node, Number)
