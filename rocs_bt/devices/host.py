"""Host: what a user's hardware drivers can use of the program."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar

from ..base.clock import Clock
from ..base.errors import DeviceError

if TYPE_CHECKING:
    from .emergency_stop import EmergencyStop

T = TypeVar("T")


class Host:
    """Clock of the run, emergency stop, and objects that the drivers of one robot share, such as a connection.

    All drivers of a robot get the same Host, except isolated actuators, which have a Host of their own in their
    process.

    Args:
        clock: Clock for the stamps of readings.
        emergency: Emergency stop of the robot; None in the process of an isolated actuator.
    """

    def __init__(self, clock: Clock, emergency: EmergencyStop | None = None) -> None:
        self.clock = clock
        self._emergency = emergency
        self._shared: dict[object, Any] = {}

    def emergency_stop(self, reason: str, source: str = "") -> None:
        """Hold all actuators of the robot in neutral, until `emergency_released` and then `go`. Thread-safe.

        Args:
            reason: Reason of the stop, such as `the button on the robot`.
            source: Name of the device or topic; a robot stays stopped until each source has released it.

        Raises:
            DeviceError: The driver runs in the process of an isolated actuator.
        """
        self._stop().stop(reason, source)

    def emergency_released(self, source: str = "") -> None:
        """End the emergency stop of one source; the robot then waits for `go`. Thread-safe.

        Raises:
            DeviceError: The driver runs in the process of an isolated actuator.
        """
        self._stop().release(source)

    def go(self, by: str = "") -> bool:
        """Let the robot move after an emergency stop, or start with `confirm`. Thread-safe.

        Args:
            by: Name of the person or device that says go, such as a topic.

        Returns:
            Whether the robot may move; False while the emergency stop is active, or a sensor is missing at the start.

        Raises:
            DeviceError: The driver runs in the process of an isolated actuator.
        """
        return self._stop().go(by)

    def _stop(self) -> EmergencyStop:
        if self._emergency is None:
            raise DeviceError("the driver of an isolated actuator cannot stop the robot: let a sensor's driver do it")
        return self._emergency

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
        """Close all shared objects that have a `close`, whatever one of them raises; then raise the first exception."""
        first: BaseException | None = None
        for shared in self._shared.values():
            try:
                if hasattr(shared, "close"):
                    shared.close()
            except BaseException as error:  # noqa: BLE001 - raised below, after the others are closed
                first = first or error
        if first is not None:
            raise first
