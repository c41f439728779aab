"""Host: what a user's own drivers get to know of the program that they run in."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

from ..clock import Clock

T = TypeVar("T")


class Host:
    """The clock of a robot's drivers, and what they share, such as one connection.

    The drivers of a robot have one Host; an isolated actuator has a Host of its own, in its own process.

    Args:
        clock: Time; readings are stamped by it.
    """

    def __init__(self, clock: Clock) -> None:
        self.clock = clock
        self._shared: dict[object, Any] = {}

    def share(self, key: object, make: Callable[[], T]) -> T:
        """The shared object of this key, made by the first driver that asks; closed at the end if it has a `close`."""
        if key not in self._shared:
            self._shared[key] = make()
        shared: T = self._shared[key]
        return shared

    def close(self) -> None:
        """Close all that is shared."""
        for shared in self._shared.values():
            if hasattr(shared, "close"):
                shared.close()
