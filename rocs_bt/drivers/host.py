"""Host: interface of the program for a user's hardware drivers."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

from ..clock import Clock

T = TypeVar("T")


class Host:
    """Clock and shared objects, such as a connection, of the drivers of one robot.

    All drivers of a robot have the same Host; an isolated actuator has a separate Host in its process.

    Args:
        clock: Clock for the stamps of readings.
    """

    def __init__(self, clock: Clock) -> None:
        self.clock = clock
        self._shared: dict[object, Any] = {}

    def share(self, key: object, make: Callable[[], T]) -> T:
        """Shared object of a key; the first call constructs it. It is closed at the end if it has a `close`.

        Args:
            key: Key of the object.
            make: Constructs the object.
        """
        if key not in self._shared:
            self._shared[key] = make()
        shared: T = self._shared[key]
        return shared

    def close(self) -> None:
        """Close all shared objects that have a `close`."""
        for shared in self._shared.values():
            if hasattr(shared, "close"):
                shared.close()
