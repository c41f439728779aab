"""ClockWatch: notices and faults of a simulator's clock during a run on hardware."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable

from ..catalog import RobotSpec
from ..clock import WallClock
from ..drivers.ros2.sim_clock import SimTimeClock
from ..errors import DeviceError

PATIENCE = 5.0
"""Wall time without a new time of the simulator until the notice [s]."""


class ClockWatch:
    """Watch of the clock of a run; without effect on a wall clock.

    Args:
        clock: Clock of the run.
        notice: Function that is called with each notice; None for none.
    """

    def __init__(self, clock: WallClock, notice: Callable[[str], None] | None) -> None:
        self._clock = clock if isinstance(clock, SimTimeClock) else None
        self._notice = notice or (lambda text: None)
        self._stopped = False

    def report_isolation(self, robots: Iterable[RobotSpec]) -> None:
        """Give notice of the isolated actuators, which cannot follow a simulator's clock in processes of their own."""
        names = [f"{robot.name}/{each.name}" for robot in robots for each in robot.actuators if each.isolated]
        if names and self._clock is not None:
            self._notice(f"use_sim_time: isolated = true has no effect on {', '.join(names)}.")

    def check(self, limit: float = math.inf) -> None:
        """Check the clock, and give notice when the simulator's time stops or goes on.

        Args:
            limit: Wall time without a new time of the simulator until the error [s]; at least `PATIENCE`.

        Raises:
            DeviceError: The simulator was restarted, or its time has stopped for the limit.
        """
        if self._clock is None:
            return
        self._clock.check()
        age = self._clock.stopped_for
        if age >= max(limit, PATIENCE):
            raise DeviceError(f"no new time on /clock for {age:.1f} s: the simulator is paused, or has ended.")
        stopped = age >= PATIENCE
        if stopped != self._stopped:
            self._stopped = stopped
            still = f"no new time on /clock for {PATIENCE:g} s: the run waits for the simulator; Ctrl-C ends it."
            self._notice(still if stopped else "/clock goes on: the run continues.")
