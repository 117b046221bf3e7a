"""What to write where a port is joined to nothing that has a mass or a place."""

from collections.abc import Collection

from lagrangia.language.flat import FlatModel
from lagrangia.language.tree import Ref


def hint_of_equation(model: FlatModel, component: str) -> str | None:
    """Where an equation names a variable of the component, which has a value of its own that reads its ports."""
    sides = (x for e in model.constraints if e.component != component for x in (e.left, e.right) if isinstance(x, Ref))
    for x in sides:
        owner, _, name = x.name.rpartition(".")
        if owner == component and (variable := model.variables.get(x.name)) and variable.binding is not None:
            return (f"'{x.name}' has a value of its own, by the ports, which an equation does not replace: bind {name} "
                    f"where {component.partition('[')[0]} is declared, ({name} = ...), of an array ({name} = {{..., ...}})")
    return None


def hint_in_a_row(model: FlatModel, port: str, island: Collection[str]) -> str:
    """For components that are joined to each other alone: springs balance each other at a place without mass; along a line what
    resists rates says nothing of where such a place is across it, so that a spring and a damper in a row are one element."""
    owners = {name.rpartition(".")[0] for name in island} - {""}
    does: dict[str, set[str]] = {owner: {e.kind for e in model.energies if e.component == owner} for owner in owners}
    for owner in {work.component for work in model.works} & owners:
        does[owner].add("work")
    if all(kinds == {"potential"} for kinds in does.values()):
        return ("a place without mass between them, which follows from the balance of their forces: "
                f"PointMass node(m = 0, center = {port})")
    if sorted(map(sorted, does.values())) == [["dissipation"], ["potential"]]:
        return ("a spring in a row with a damper is one element, MaxwellSpring(k = ..., c = ...); one in a row with dry friction "
                "is JenkinsSpring(k = ..., F = ...)")
    return f"a place with a mass between them: PointMass node(m = ..., center = {port})"
