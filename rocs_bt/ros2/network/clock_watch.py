"""ClockWatch: notices and faults of a simulator's clock during a run on hardware."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from contextlib import suppress

from ...base.errors import ActuatorError, DeviceError
from ...catalog import RobotSpec
from ...interfaces.safety_gate import SafetyGate
from .sim_clock import SimTimeClock

PATIENCE = 5.0
"""Wall time without a new time of the simulator until the notice [s]."""

_INTERVALS = 5  # messages of the simulator that must be missing before a gate goes to neutral


class ClockWatch:
    """Watch of a simulator's clock.

    The watchdogs of the gates follow the clock of the run, so they stop with it. The watch therefore sends moving
    gates to neutral by wall time.

    Args:
        clock: Clock of the run.
        gates: Safety gates of all robots.
        notice: Function that is called with each notice; None for none.
    """

    def __init__(self, clock: SimTimeClock, gates: Iterable[SafetyGate], notice: Callable[[str], None] | None) -> None:
        self._clock = clock
        self._gates = list(gates)
        self._notice = notice or (lambda text: None)
        self._stopped = False

    def report_isolation(self, robots: Iterable[RobotSpec]) -> None:
        """Give notice of the isolated actuators, which cannot follow a simulator's clock in processes of their own."""
        names = [f"{robot.name}/{each.name}" for robot in robots for each in robot.actuators if each.isolated]
        if names:
            self._notice(f"use_sim_time: isolated = true has no effect on {', '.join(names)}.")

    def check(self, limit: float = math.inf) -> None:
        """Check the clock: send the gates to neutral, and give notice, when the simulator's time stops.

        Args:
            limit: Wall time without a new time of the simulator until the error [s]; at least `PATIENCE`.

        Raises:
            DeviceError: The simulator was restarted, or its time has stopped for the limit.
        """
        self._clock.check()
        age = self._clock.stopped_for
        for gate in self._gates:
            if gate.active and age > max(gate.max_age, _INTERVALS * self._clock.interval):
                with suppress(ActuatorError):  # reported by the gate, and the others must stop
                    gate.neutral()
        if age >= max(limit, PATIENCE):
            raise DeviceError(f"no new time on /clock for {age:.1f} s: the simulator is paused, or has ended.")
        stopped = age >= PATIENCE
        if stopped != self._stopped:
            self._stopped = stopped
            still = f"no new time on /clock for {PATIENCE:g} s: the run waits for the simulator; Ctrl-C ends it."
            self._notice(still if stopped else "/clock goes on: the run continues.")


class RunClock(SimTimeClock):
    """Clock of a run that a simulator sets; see `running.hardware_services.WatchedClock`."""

    def watch(
        self, gates: Iterable[SafetyGate], robots: Iterable[RobotSpec], notice: Callable[[str], None] | None
    ) -> Callable[[float], None]:
        """Function that checks the clock, with the wall time [s] that it may stop until a DeviceError."""
        watch = ClockWatch(self, gates, notice)
        watch.report_isolation(robots)
        return watch.check
