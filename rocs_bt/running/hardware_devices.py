"""Devices of all robots of a run on hardware, behind their safety gates."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack, closing

from ..agent import RobotDevices
from ..base.clock import Rate, WallClock
from ..catalog import ActuatorSpec, Catalog, RobotSpec, command_size
from ..drivers.emergency_stop import EmergencyStop
from ..drivers.host import Host
from ..drivers.isolated import IsolatedActuator
from ..event import EventSink
from ..interfaces.device import Actuator
from ..interfaces.safety import SafetyGate
from ..simulation.devices import hardware_driver, make_hardware, make_isolated, make_sensor
from .hardware_services import RobotService, ServicePlace, WatchedClock, services_of
from .options import RunOptions
from .preflight import PreflightTopic


def hardware_clock(robots: Sequence[RobotSpec], stack: ExitStack, wait: float, ended: Callable[[], str]) -> WallClock:
    """Clock of a run: that of a service of the robots, such as a simulator's; by default the wall clock.

    Args:
        robots: All robots of the run.
        stack: Exit stack that leaves the clock's network.
        wait: Maximum time to wait for the clock [s].
        ended: Returns the reason of a signal that ends the run, or an empty text.

    Raises:
        InputError: The robots would have different clocks.
        DeviceError: There is no time.
    """
    services = {name: service for robot in robots for name, service in services_of(robot).items()}
    found = (service.clock(robots, stack, wait, ended) for service in services.values())
    return next((clock for clock in found if clock is not None), None) or WallClock(running=False)


class HardwareDevices:
    """Devices of all robots.

    Args:
        clock: Clock of the run.
        period: Control period [s].
        sink: Sink for events of the safety gates.
        options: Options of the run, for which no actuator is opened in a dry run, each robot may wait for a go from the
            beginning, and notices are given, such as that a goal may go on after the run.
    """

    def __init__(self, clock: WallClock, period: float, sink: EventSink, options: RunOptions) -> None:
        self.clock = clock
        self.sink = sink
        self._period = period
        self._dry_run = options.dry_run
        self._confirm = options.confirm
        self._notice = options.notice or (lambda text: None)
        self.robots: dict[str, RobotDevices] = {}
        self.motion: dict[str, SafetyGate] = {}  # of the locomotion, by agent
        self.links: dict[str, list[IsolatedActuator]] = {}
        self.stops: dict[str, EmergencyStop] = {}
        self.topics: list[PreflightTopic] = []  # topics that need a node at the other side
        self.services: list[RobotService] = []

    @property
    def gates(self) -> list[SafetyGate]:
        """Safety gates of all actuators of all robots."""
        return [gate for each in self.robots.values() for gate in each.actuators.values()]

    def open(
        self,
        name: str,
        robot: RobotSpec,
        rates: Mapping[str, Rate],
        catalog: Catalog,
        shared: ExitStack,
        opened: ExitStack,
    ) -> None:
        """Open the devices of an agent's robot.

        `shared` closes the host, which the devices share, and `opened` closes the devices.
        """
        stop = self.stops[name] = EmergencyStop(confirm=self._confirm)
        host = Host(self.clock, stop)
        shared.callback(host.close)
        sensors = {
            s.name: opened.enter_context(closing(make_sensor(catalog, robot, s, host, rates[s.name])))
            for s in robot.sensors
        }
        made = {a.name: opened.enter_context(closing(self._actuator(catalog, robot, a, host))) for a in robot.actuators}
        gates = {a.name: a.guard(made[a.name], self.clock, self._period, self.sink, name) for a in robot.actuators}
        stop.attach(list(gates.values()))
        place = ServicePlace(name, robot, host, made, self.sink, self._dry_run, self._notice)
        links = {}
        for key, service in services_of(robot).items():
            beside = service(place)
            shared.callback(beside.close)
            links[key] = beside.link
            self.topics += beside.topics
            self.services.append(beside)
        self.robots[name] = RobotDevices(robot, sensors, gates, rates, links)
        self.motion[name] = gates[robot.motion.actuator]
        self.links[name] = [device for device in made.values() if isinstance(device, IsolatedActuator)]

    def _actuator(self, catalog: Catalog, robot: RobotSpec, spec: ActuatorSpec, host: Host) -> Actuator:
        """Device of an actuator; for an isolated actuator, the link to its process; in a dry run, none."""
        if self._dry_run:
            hardware_driver(catalog, robot, spec)  # refuses what a real run refuses
            return NoActuator(spec.name, command_size(robot, spec))
        if spec.isolated and not isinstance(self.clock, WatchedClock):  # a process of its own has the wall clock
            return make_isolated(catalog, robot, spec, host)
        device: Actuator = make_hardware(catalog, robot, spec, host)
        return device


class NoActuator(Actuator):
    """Actuator of a dry run, without a device."""

    def command(self, values: Sequence[float]) -> None:
        """Ignore the command; the agent records it."""

    def neutral(self) -> None:
        """Do nothing."""
