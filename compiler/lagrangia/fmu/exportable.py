"""What an exporter asks of a compiled scene."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from lagrangia.run.origin import Origin
from lagrangia.run.request import Request
from lagrangia.run.scene import Scene

if TYPE_CHECKING:
    import casadi
    import numpy as np

    from lagrangia.compile.pipeline import Compilation


class Exportable(Protocol):
    """What is asked of a compiled scene: a Model (model.py)."""

    origin: Origin
    model: str | None
    structural: dict[str, Any]
    outputs: tuple[str, ...]
    scene: Scene

    @property
    def path(self) -> Path:
        """Of its file."""

    @property
    def compilation(self) -> "Compilation":
        """The formulas."""

    def functions(self) -> "dict[str, casadi.Function]":
        """CasADi functions, by name."""

    def equations(self) -> str:
        """The equations of motion as text."""

    def parameter_values(self, parameters: Mapping[str, float] | None = None) -> "np.ndarray":
        """All parameters, (n_parameters,), with some changed."""

    def run(self, request: Request) -> Any:
        """A run, to know the state it starts from."""
