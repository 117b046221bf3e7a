"""Components of a scene that is flattened again after a change of its text: those that did not change are not made again.

A component follows from its declaration, which a text that is being written keeps (editor/live_text.py), its class, and what
is asked of values outside while it is made. Those that ask nothing are kept, with the instance of the scene that they lie in,
as long as all other classes are the same.
"""

from lagrangia.base.records import dataclass
from lagrangia.language.alike_elements import First, can_be_copied
from lagrangia.language.classes import ClassTable
from lagrangia.language.frame_attributes import Space
from lagrangia.language.instances import Bound, Instance, Member, Scope, StructuralValues
from lagrangia.language.tree import Boolean, ClassDefinition, Declaration, Expression, Number, Reference


@dataclass(frozen=True)
class _Kept:
    declaration: Declaration
    sizes: tuple[int, ...]
    member: Member
    count: int  # of components in it


class KeptComponents:
    """Of the last scene that was flattened with these."""

    def __init__(self) -> None:
        self.space: Space | None = None
        self.others: list[ClassDefinition] = []
        self.root: Instance | None = None
        self.last: dict[int, _Kept] = {}  # by the ids of declarations
        self.now: dict[int, _Kept] = {}
        self.own: frozenset[int] = frozenset()  # the ids of the scene's own declarations: no other class modifies them

    def begin(self, table: ClassTable, root: Instance, space: Space) -> Instance:
        """A scene is flattened: what it lies in from now on."""
        others = [c for c in table.user.values() if c is not root.definition]
        is_same = (space is self.space and not table.files and len(others) == len(self.others)
                   and all(map(lambda a, b: a is b, others, self.others)))
        self.space, self.others, self.last, self.now = space, others, self.now if is_same else {}, {}
        self.own = frozenset() if table.files else frozenset(map(id, root.definition.elements))
        if self.root is None or not is_same:
            self.root = root
        else:
            self.root.__dict__ |= root.__dict__
        return self.root

    def found(self, declaration: Declaration, sizes: tuple[int, ...]) -> _Kept | None:
        """What was made of a declaration."""
        kept = self.last.get(id(declaration))
        if kept is None or kept.declaration is not declaration or kept.sizes != sizes:
            return None
        self.now[id(declaration)] = kept
        return kept

    def keep(self, declaration: Declaration, sizes: tuple[int, ...], member: Member, count: int) -> None:
        """For the next time, if it names no component around it."""
        if id(declaration) in self.own and can_be_copied(member, First(1)):
            self.now[id(declaration)] = _Kept(declaration, sizes, member, count)


class Asked(StructuralValues):
    """Values, and whether one was asked for that is not written where it is asked."""

    def __init__(self, values: StructuralValues) -> None:
        self.values, self.space, self.any = values, values.space, False

    def integer(self, expression: Expression, scope: Scope, what: str, hint: str = "") -> int:
        """The integer that an expression must be. Raises LagError L0210."""
        self.any |= not isinstance(expression, Number)
        return self.values.integer(expression, scope, what, hint)

    def boolean(self, expression: Expression, scope: Scope, what: str, *hints: str) -> bool:
        """The truth value that an expression must be. Raises LagError L0210."""
        self.any |= not isinstance(expression, Boolean)
        return self.values.boolean(expression, scope, what, *hints)

    def shape(self, bound: Bound) -> tuple[int, ...]:
        """The sizes of what is bound. Raises LagError."""
        self.any = True
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
        self.any = True
        return self.values.count_of_literals(node)
