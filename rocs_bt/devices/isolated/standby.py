"""Standby: second way to the device of an isolated actuator, after its process has ended or was killed."""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import suppress

from ...base.raised import describe
from ...interfaces.device import Actuator
from ..last_neutral import repeat_neutral

SOON = 0.5
"""Time for which `take_over` waits for the device to be in neutral [s]."""


class Standby:
    """Opens a device in the main process, and sends it to neutral.

    With `early` it is opened now, as it allows two owners. Otherwise it is opened when it is needed, after the process
    that has it open has ended.

    Raises:
        InputError: The device is opened early, and the driver is invalid.
        DeviceError: The device is opened early, and cannot be reached.
    """

    def __init__(self, make: Callable[[], Actuator], *, early: bool) -> None:
        self._make = make
        self._device = make() if early else None
        self._active = self._closed = False
        self._thread = threading.Thread(target=self._run, name="standby", daemon=True)
        self._problem = "the driver has not opened its device yet"
        self._lock = threading.Lock()  # of opening, closing, and `stop`
        self._stopping = threading.Event()

    def take_over(self) -> str:
        """Open the device, send it to neutral several times; returns why it is not in neutral after `SOON`."""
        self._thread.start()
        self._thread.join(SOON)
        return self._problem

    def stop(self) -> None:
        """Send the device to neutral once, if it is open, in a thread of its own: the caller does not wait for it."""
        if not self._stopping.is_set():  # a neutral on its way is enough
            self._stopping.set()
            threading.Thread(target=self._stop, name="standby/stop", daemon=True).start()

    def neutral(self) -> None:
        """Send the device to neutral, if it is open, and the standby has taken over."""
        if self._active and self._device is not None:
            self._device.neutral()

    def close(self) -> None:
        """Close the device if it was opened; not while its driver hangs."""
        self._closed = True
        if not self._lock.acquire(timeout=SOON):
            return
        device, self._device = self._device, None
        self._lock.release()
        if device is not None:
            device.close()

    def _run(self) -> None:
        try:
            with self._lock:
                if self._closed:
                    return
                self._device = self._device or self._make()
            self._active, self._problem = True, "the driver's neutral has not returned yet"
            repeat_neutral(self._try)
        except (Exception, SystemExit) as error:  # noqa: BLE001 - a user's driver may raise anything
            self._problem = describe(error)

    def _stop(self) -> None:
        try:
            with suppress(Exception, SystemExit), self._lock:  # a user's driver may raise anything
                if self._device is not None:
                    self._device.neutral()
        finally:
            self._stopping.clear()

    def _try(self) -> None:
        """Send the device to neutral; the next attempt is made also if this one raises."""
        try:
            self.neutral()
            self._problem = ""
        except Exception as error:  # noqa: BLE001 - a user's driver may raise anything
            self._problem = describe(error)
