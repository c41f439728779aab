"""Host: what a user's hardware drivers can use of the program."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

from ..clock import Clock

T = TypeVar("T")


class Host:
    """Clock of the run, and objects that the drivers of one robot share, such as a connection.

    All drivers of a robot get the same Host, except isolated actuators, which have a Host of their own in their
    process.

    Args:
        clock: Clock for the stamps of readings.
    """

    def __init__(self, clock: Clock) -> None:
        self.clock = clock
        self._shared: dict[object, Any] = {}

    def share(self, key: object, make: Callable[[], T]) -> T:
        """Get the shared object of a key. The first call constructs it; at the end it is closed if it has a `close`.

        Args:
            key: Key that identifies the object.
            make: Function that constructs the object.
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
