"""The analyses of a model, as Python asks for them."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from lagrangia.base.checked_values import MOST_POINTS, a_count_within, a_frequency, a_span, any_names, numbers

if TYPE_CHECKING:
    from lagrangia.study.analysis import Study
    from lagrangia.study.equilibria import Equilibria
    from lagrangia.study.linearization import Linearization
    from lagrangia.study.modes import Modes
    from lagrangia.study.response import Response

REACTION = ".reaction"  # in the names of reactions
Given = Mapping[str, float] | None


class Analysed(ABC):
    """What has small motion and places of rest."""

    @abstractmethod
    def study(self, parameters: Given = None, initial: Given = None, inputs: Any = None, time: float | None = None) -> "Study":
        """What they are found of, with these numbers, at one time (s). Raises LagError."""

    @abstractmethod
    def telling_reactions(self, names: Sequence[str] = (REACTION,)) -> "Analysed":
        """The same, that can be asked for these quantities, should reactions be among them."""

    def equilibrium(self, *, parameters: Given = None, initial: Given = None, inputs: Given = None, time: float | None = None,
                    starts: int | None = None) -> "Equilibria":
        """Positions of rest: the one reached from the start values first, then those found from `starts` - 1 other places.

        Each has `.position`, `.stability`, `.eigenvalues`, `.reactions`; time stands still at `time` (s), the start time by
        default. Raises LagError for wrong input, RunError where nothing can rest.
        """
        return self.telling_reactions().study(parameters, initial, inputs, time).equilibria(starts)

    def linearize(self, *, about: str = "equilibrium", excitations: str | Sequence[str] | None = None,
                  outputs: str | Sequence[str] | None = None, parameters: Given = None, initial: Given = None,
                  inputs: Given = None, time: float | None = None) -> "Linearization":
        """M, C, K and the state-space form of small motion about the equilibrium found from the start, where supports stand still
        as they are at `time` (s), or about the "start" taken at that time, with the rates and accelerations of supports.

        `excitations` and `outputs` are names; by default the inputs with all loads that depend on time, and the coordinates with
        the declared outputs. See `lag help analysis`. Raises LagError, RunError.
        """
        chosen = any_names("outputs", outputs)
        study = self.telling_reactions(chosen or ()).study(parameters, initial, inputs, time)
        found = study.linearize(about, any_names("excitations", excitations), chosen)
        if not study.c.flat.samplers:
            return found
        from lagrangia.study.sampled import with_sampled_system

        return with_sampled_system(study, found, about)

    def modes(self, *, about: str = "equilibrium", mass_normalised: bool = False, parameters: Given = None, initial: Given = None,
              inputs: Given = None, time: float | None = None) -> "Modes":
        """Natural frequencies, mode shapes and damping ratios about the equilibrium, or about the "start": see `linearize`."""
        return self.study(parameters, initial, inputs, time).modes(about, mass_normalised)

    def response(self, excitations: str | Sequence[str] | None = None, outputs: str | Sequence[str] | None = None, *,
                 frequencies: Sequence[float] | None = None, span: tuple[float, float] | None = None, points: int = 400,
                 about: str = "equilibrium", parameters: Given = None, initial: Given = None, inputs: Given = None,
                 time: float | None = None) -> "Response":
        """Frequency response of outputs to excitations, at `frequencies` (Hz) or over `span` (Hz, from the modes by default)."""
        chosen = any_names("excitations", excitations), any_names("outputs", outputs)
        at = None if frequencies is None else [a_frequency(value) for value in numbers("frequencies", frequencies)]
        ends = None if span is None else a_span(span)
        count = a_count_within("number of points", points, 2, MOST_POINTS)
        asked = self.telling_reactions(chosen[1] or ())
        return asked.study(parameters, initial, inputs, time).response(*chosen, about, at, ends, count)
