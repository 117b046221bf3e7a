"""One scalar of an FMU, as both versions of the standard describe it."""

from lagrangia.base.records import dataclass


@dataclass(frozen=True)
class Variable:
    """One scalar. `initial` and `start` as the standards have them; `derivative_of` names a state."""

    name: str
    group: str
    reference: int
    causality: str
    variability: str
    initial: str | None = None
    start: float | bool | str | None = None
    unit: str = ""
    display_unit: str = ""
    description: str = ""
    minimum: float | None = None
    maximum: float | None = None
    nominal: float | None = None
    derivative_of: str | None = None
    aliases: tuple[str, ...] = ()
    type_name: str = ""  # of outputs that are no Reals: Integer, Boolean

    @property
    def kind(self) -> str:
        """Real, Integer, Boolean or String."""
        return self.type_name or {"integer": "Integer", "boolean": "Boolean", "string": "String",
                "kept_integer": "Integer", "kept_boolean": "Boolean"}.get(self.group, "Real")
