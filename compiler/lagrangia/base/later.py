"""A value that is worked out when somebody first asks for it: what many scenes never need, or need late."""

from collections.abc import Callable
from functools import cached_property
from typing import Generic, TypeVar

T = TypeVar("T")


class Later(Generic[T]):
    """Records that take its place (dataclasses.replace) share it, and so it is worked out once."""

    def __init__(self, make: Callable[[], T]) -> None:
        self._make = make

    @cached_property
    def value(self) -> T:
        """What was promised."""
        return self._make()

    @property
    def is_known(self) -> bool:
        """Whether somebody has asked for it."""
        return "value" in self.__dict__
