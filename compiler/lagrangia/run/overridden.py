"""Parameters that are given for a run and change nothing in it, as all that reads them is given as well: -p L=2 -p p.L=3, where
p.L alone reads L; -p phi0=1 --initial p.phi=2, where phi0 is where p.phi starts."""

from collections.abc import Collection, Iterable, Mapping

from lagrangia.base.cutting import stem
from lagrangia.run.scene import Scene

Readers = Mapping[str, list[str]]  # as parameter_readers.find_readers has them


def may_be_overridden(parameters: Collection[str], initial: Collection[str]) -> bool:
    """Whether it is worth asking what reads what."""
    return bool(parameters) and len(parameters) + len(initial) > 1


def overridden_remarks(scene: Scene, readers: Readers, parameters: Collection[str], initial: Collection[str]) -> list[str]:
    """A warning for each of the `parameters`, as `lag` prints them."""
    values = _Given(scene, parameters, initial)
    found = []
    for name in parameters:
        base = stem(name)
        if base in readers and not values.counts(base, readers) and (told := values.instead_of(base, readers)):
            verb = "is" if len(told) == 1 else "are"
            shown = " and ".join(map("'{}'".format, told[:3])) + (f" and {len(told) - 3} more" if len(told) > 3 else "")
            found.append(f"warning[L0747]: the value given for '{name}' changes nothing: {shown} {verb} given as well, and "
                         "nothing else reads it\n   = leave one of them out")
    return found


class _Given:
    """What is given for a run, by the names of what is declared."""

    def __init__(self, scene: Scene, parameters: Collection[str], initial: Collection[str]) -> None:
        self.scene, self.given = scene, set(parameters)
        self.places = {place for name in initial if (place := self._place(name)) is not None}
        self.elements: dict[str, list[str]] = {}
        for parameter in scene.parameters:
            self.elements.setdefault(stem(parameter.name), []).append(parameter.name)

    def counts(self, name: str, readers: Readers) -> bool:
        """Whether something that the run computes depends on it."""
        return any(not self._is_given(reader) and (reader not in readers or self.counts(reader, readers))
                   for reader in readers.get(name, ()))

    def instead_of(self, name: str, readers: Readers) -> list[str]:
        """Those given that read it, directly or not, as people call them."""
        found: dict[str, None] = {}
        for reader in readers.get(name, ()):
            own = [_called(reader)] if self._is_given(reader) else self.instead_of(reader, readers)
            found |= dict.fromkeys(own)
        return list(found)

    def _is_given(self, reader: str) -> bool:
        if reader.startswith("start("):
            return self._place(_called(reader)) in self.places
        return reader in self.given or all(label in self.given for label in self.elements.get(reader, (reader,)))

    def _place(self, name: str) -> tuple[str, int] | None:
        """Of a start, which may have several names."""
        slot = self.scene.slot(name)
        if slot is not None:
            return "state", slot
        return ("lost", self.scene.lost[name][0]) if name in self.scene.lost else None


def _called(reader: str) -> str:
    """As people call it."""
    return reader[len("start(") : -1] if reader.startswith("start(") else reader


def all_names(*groups: Iterable[str] | None) -> list[str]:
    """Once each; what is given for names and is none, the run refuses."""
    known = (group for group in groups if isinstance(group, Mapping | list))
    return list(dict.fromkeys(name for group in known for name in group if isinstance(name, str)))
