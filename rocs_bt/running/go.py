"""Permission of the robots of a run on hardware to move: their emergency stops, and the person at the terminal."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from ..drivers.emergency_stop import EmergencyStop
from ..drivers.ros2.command_watch import CommandWatch
from ..drivers.ros2.stop_topics import StopTopics


class MotionPermission:
    """Emergency stops of all robots of a run, with the person at the terminal.

    Args:
        stops: Emergency stops of the robots.
        asked: Function called once per control period, which returns whether the person said go since its last call;
            None without a person.
        topics: Topics that stop a robot or let it go, and topics of commands.
    """

    def __init__(
        self,
        stops: Sequence[EmergencyStop],
        asked: Callable[[], bool] | None = None,
        topics: Sequence[StopTopics | CommandWatch] = (),
    ) -> None:
        self._stops = stops
        self._asked = asked
        self._topics = topics

    def poll(self, ready: bool = True) -> str:
        """Read the topics, and pass a go of the person to the robots that wait for it.

        Args:
            ready: Whether the robots may start; if not, no go counts, also not that of a driver.

        Returns:
            Reason for which a robot must not move; empty if all robots may.
        """
        for stop in self._stops:
            stop.ready = ready
        for topic in self._topics:
            topic.poll()
        if self._asked is not None and self._asked():  # called in each period, so that no old answer is kept
            for stop in self._stops:
                stop.go("the terminal")
        return next((stop.reason for stop in self._stops if stop.reason), "")
