"""Emergency stop of a robot on hardware: neutral until it is released and a person says go."""

from __future__ import annotations

import threading
from collections.abc import Sequence

from ..interfaces.safety_gate import SafetyGate

WAITING = "waiting for go"
"""Last words of the reason for which a robot is held that only needs a go."""


class EmergencyStop:
    """State machine that decides whether a robot may move; thread-safe.

    The robot may move, or it is stopped, or it waits for a go. `stop` stops it. When every source that stopped it has
    released it, it waits. `go` lets it move again; while it is stopped, `go` has no effect. Drivers call these methods
    through their `Host`, and a person at the terminal through `RunOptions.go`.

    Args:
        confirm: Whether the robot waits for a go from the beginning.

    Attributes:
        ready: Whether a go counts; the preflight check sets it to False while sensors are missing.
    """

    def __init__(self, *, confirm: bool = False) -> None:
        self.ready = True
        self._sources: dict[str, str] = {}  # reasons by source
        self._waiting = WAITING if confirm else ""
        self._gates: Sequence[SafetyGate] = ()
        self._lock = threading.Lock()

    @property
    def reason(self) -> str:
        """Reason for which the robot must not move; empty if it may."""
        with self._lock:
            return self._reason

    def attach(self, gates: Sequence[SafetyGate]) -> None:
        """Connect the safety gates of the robot's actuators, which are held while the robot is stopped or waits."""
        with self._lock:
            self._gates = gates
            if self._sources:
                self._hold()

    def stop(self, reason: str, source: str = "") -> None:
        """Stop the robot: neutral at once.

        Args:
            reason: Reason of the stop, such as `the button on the robot`.
            source: Name of the device or topic; a robot stays stopped until each source has released it.
        """
        with self._lock:
            if self._sources.get(source) != reason:
                self._sources[source] = reason
                self._hold()

    def release(self, source: str = "") -> None:
        """End the stop of one source; without a stop of this source, do nothing."""
        with self._lock:
            if self._sources.pop(source, None) is not None:
                if not self._sources:
                    self._waiting = f"emergency stop released, {WAITING}"
                self._hold()

    def pause(self, by: str) -> None:
        """Send the robot to neutral until a person says go."""
        with self._lock:
            self._waiting = f"paused by {by}, {WAITING}"
            self._hold()

    def go(self, by: str = "") -> bool:
        """Let the robot move if it only waits for a go; returns whether it may move."""
        with self._lock:
            if self._sources or not self.ready:
                return False
            if self._waiting:
                self._waiting = ""
                for gate in self._gates:
                    gate.release(by)
            return True

    @property
    def _reason(self) -> str:
        reasons = dict.fromkeys(self._sources.values())
        return f"emergency stop: {', '.join(reasons)}" if self._sources else self._waiting

    def _hold(self) -> None:
        """Hold all gates, whatever one of them raises; then raise the first exception."""
        reason, first = self._reason, None
        for gate in [gate for gate in self._gates if gate.mark_held(reason)]:
            try:
                gate.begin_hold()
            except BaseException as error:  # noqa: BLE001 - raised below, after the other gates are held
                first = first or error
        if first is not None:
            raise first
