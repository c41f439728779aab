"""Services of packages beside robots on hardware, registered in `rocs_bt.services` by the name of the robot's table."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

from ..base.clock import WallClock
from ..base.registered import load, registered
from ..catalog import RobotSpec
from ..devices.host import Host
from ..event import EventSink
from ..interfaces.device import Actuator
from ..interfaces.safety_gate import SafetyGate
from .preflight import PreflightTopic


@dataclass(frozen=True)
class ServicePlace:
    """What the service of a robot gets."""

    agent: str
    robot: RobotSpec
    host: Host
    actuators: Mapping[str, Actuator]  # devices by name
    sink: EventSink
    dry_run: bool  # nothing must be sent
    notice: Callable[[str], None]


class RobotService(Protocol):
    """Service of one robot.

    Attributes:
        link: Object that nodes of missions find in `services`, under the name of the service.
        topics: Topics that must have a node at the other side before the robot starts.
    """

    link: Any
    topics: Sequence[PreflightTopic]

    def poll(self) -> None:
        """Look at what the service watches; called once per control period, and before the start."""

    def close(self) -> None:
        """Close the service, after the devices."""


@runtime_checkable
class WatchedClock(Protocol):
    """Clock of a run that may stop, such as that of a simulator; processes of their own cannot follow it."""

    def watch(
        self, gates: Iterable[SafetyGate], robots: Iterable[RobotSpec], notice: Callable[[str], None] | None
    ) -> Callable[[float], None]:
        """Function that checks the clock, with the wall time [s] that it may stop until a DeviceError."""


class HardwareService(Protocol):
    """Registered service: it is called with the place of each robot that has its table."""

    def __call__(self, place: ServicePlace) -> RobotService: ...

    def clock(
        self, robots: Sequence[RobotSpec], stack: ExitStack, wait: float, ended: Callable[[], str]
    ) -> WallClock | None:
        """Clock of a run; None for the wall clock. The stack closes what it uses.

        Args:
            robots: All robots of the run.
            stack: Exit stack of the run.
            wait: Maximum time to wait for the clock [s].
            ended: Returns the reason of a signal that ends the run, or an empty text.

        Raises:
            InputError: The robots would have different clocks.
            DeviceError: There is no time.
        """


def services_of(robot: RobotSpec) -> dict[str, HardwareService]:
    """Registered services of the robot's tables, by name.

    Raises:
        InputError: One cannot be loaded.
    """
    return {name: load("rocs_bt.services", name) for name in robot.tables if name in registered("rocs_bt.services")}
