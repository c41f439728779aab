"""HardwareStage: a run on the robots themselves.

Missions, rules, blocks and rates are the same as in simulation. Only the drivers in each robot.toml differ: classes of
the user (`driver = "file.py:Class"`) that communicate with the robot. Without ground truth, the outcomes are determined
from the robots' own estimates.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, closing, contextmanager, suppress
from functools import partial

from ..agent import Agent, AgentRuntime, RobotDevices, ThreadedRunner
from ..agent.lateness import load
from ..base.clock import Rate, WallClock, wait_until
from ..catalog import ActuatorSpec, Catalog, RobotSpec, ScenarioSpec, command_size
from ..catalog.registered_devices import registered_devices
from ..devices.emergency_stop import EmergencyStop
from ..devices.host import Host
from ..devices.isolated import IsolatedActuator
from ..devices.last_neutral import repeat_neutral
from ..event import BodyMoved, EventSink, Stuck
from ..interfaces.device import Actuator
from ..interfaces.safety_gate import SafetyGate
from ..simulation.outcome import Judge
from .build_agents import build_agents
from .hardware_devices import hardware_driver, make_hardware, make_isolated, make_sensor
from .hardware_services import RobotService, ServicePlace, WatchedClock, services_of
from .preflight import Preflight, PreflightTopic, preflight_sensors
from .run_loop import brake
from .run_options import RunOptions


class HardwareStage:
    """Robots of a scenario as the stage of a run. Opens the devices and builds the agents.

    Attributes:
        clock: Clock of the run.
        agents: Agents of the scenario.
        judges: Judges of the outcomes, by agent.
        start: Time of the first control period [s], from `ready`.

    Raises:
        InputError: The content is invalid.
        DeviceError: A driver cannot reach its device.
    """

    time_stops = False
    trajectory_hash = None

    def __init__(
        self,
        spec: ScenarioSpec,
        catalog: Catalog,
        options: RunOptions,
        sink: EventSink,
        stack: ExitStack,
        ended: Callable[[], str],
    ) -> None:
        self.robots = {agent.name: catalog.robot_of(agent) for agent in spec.agents}
        self.clock = hardware_clock(list(self.robots.values()), stack, options.wait, ended)
        self.start = 0.0
        self.judges: Mapping[str, Judge] = {}
        self._spec = spec
        self._options = options
        self._sink = sink
        self._period = spec.rate.control_rate.period
        self._late: set[tuple[str, str]] = set()  # agents, and their actuators with a late process
        self._stuck: set[str] = set()
        self._devices = HardwareDevices(self.clock, self._period, sink, options)
        self.agents = self._build(catalog, stack)
        self._check_clock: Callable[[float], None] = lambda limit: None
        if isinstance(self.clock, WatchedClock):
            self._check_clock = self.clock.watch(self._devices.gates, self.robots.values(), options.notice)

    def _build(self, catalog: Catalog, stack: ExitStack) -> list[Agent]:
        """Open the devices and build the agents; the stack closes both."""
        spec, options, devices = self._spec, self._options, self._devices
        opened = stack.enter_context(ExitStack())
        for name, robot in self.robots.items():
            rates = {s.name: spec.rate.sensor_rate(s.rate, s.name) for s in robot.sensors}
            devices.open(name, robot, rates, catalog, stack, opened)
        runtime = AgentRuntime(self.clock, self._sink, time.perf_counter)
        agents = build_agents(spec, catalog, devices.robots, runtime, seed=options.seed, missions=options.missions)
        opened.pop_all()  # from here on the agents close their devices
        return agents

    def ready(self, ended: Callable[[], str]) -> bool:
        """Wait in neutral until the robots may start; False if a signal ended the run before.

        Raises:
            DeviceError: A needed sensor was not fresh for the whole time `wait`.
        """
        self.clock.start()
        devices, options = self._devices, self._options
        sensors = [sensor for agent in self.agents for sensor in preflight_sensors(agent, self.robots[agent.name])]
        preflight = Preflight(
            [*sensors, *devices.topics], self.clock, self._period, wait=options.wait, show=options.preflight
        )
        ready = preflight.run(ended, partial(self._poll, limit=options.wait))
        self.start = self.clock.now()
        self.judges = {agent.name: Judge(end_on_stuck=False, start=self.start) for agent in self.agents}
        return ready

    @contextmanager
    def playing(self, ended: Callable[[], str]) -> Iterator[Iterator[float]]:
        """Context in which the agents' threads run; see `Stage.playing`."""
        with ExitStack() as stack:
            for agent in self.agents:
                stack.enter_context(ThreadedRunner(agent, self.clock))
            stack.callback(brake, self.agents)
            yield self._periods(ended)

    def _periods(self, ended: Callable[[], str]) -> Iterator[float]:
        due, never = self.start, threading.Event()
        while wait_until(self.clock, due, never, ended, self._poll):
            t = self.clock.now()
            yield t
            due += self._period * max(1.0, math.ceil((t - due) / self._period))

    def observe(self, t: float) -> None:
        """Check the devices of all agents, and judge the agents."""
        self._poll()
        for gate in self._devices.gates:
            gate.check()
        for agent in self.agents:
            for link in self._devices.links[agent.name]:
                if (error := link.check()) is not None:
                    agent.fail(link.name, error.kind, str(error), error, owner="content")
                else:
                    self._watch_process(agent, link)
            self._judge(t, agent)

    def advance(self, t: float) -> None:
        """Do nothing: the robots go on by themselves."""

    def rest(self) -> None:
        """Repeat the neutral command, which the last message may have lacked."""
        repeat_neutral(self._neutral)

    def pause(self, by: str) -> None:
        """Send all robots to neutral, as after an emergency stop."""
        for stop in self._devices.stops.values():
            stop.pause(by)

    def resume(self, by: str) -> None:
        """Do nothing: only a person at the robots lets them move again."""

    def _poll(self, ready: bool = True, limit: float = math.inf) -> str:
        """Check the clock, read the topics, and pass a go of the person to the robots that wait for it.

        Args:
            ready: Whether the robots may start; if not, no go counts, also not that of a driver.
            limit: Wall time without a new time of the simulator until the error [s].

        Returns:
            Reason for which a robot must not move; empty if all robots may.
        """
        self._check_clock(limit)
        stops, go = self._devices.stops.values(), self._options.go
        for stop in stops:
            stop.ready = ready
        for service in self._devices.services:
            service.poll()
        if go is not None and go():  # called in each period, so that no old answer is kept
            for stop in stops:
                stop.go("the terminal")
        return next((stop.reason for stop in stops if stop.reason), "")

    def _neutral(self) -> None:
        for gate in self._devices.gates:
            with suppress(Exception):  # a driver that fails is reported already, and the others must stop
                gate.neutral()

    def _watch_process(self, agent: Agent, link: IsolatedActuator) -> None:
        """Hold an agent while the process of its actuator is late."""
        key, source = (agent.name, link.name), f"late process of {link.name}"
        if link.late and key not in self._late:
            self._late.add(key)
            why = "the machine is busy, its driver waits, or it was stopped"
            agent.hold(f"the process of actuator {link.name} is late: {why}{load()}", source)
        elif not link.late and key in self._late:
            self._late.remove(key)
            agent.resume(source, f"{link.name}, on time again")

    def _judge(self, t: float, agent: Agent) -> None:
        name, judge, pose = agent.name, self.judges[agent.name], agent.knowledge.robot.pose()
        if math.isfinite(pose.x):
            self._sink.emit(BodyMoved(t=t, agent=name, body=name, x=pose.x, y=pose.y, yaw=pose.yaw))
        if judge.decided:
            return
        gate = self._devices.motion[name]
        if judge.update(t, pose, agent, commanded=gate.active, paused=bool(gate.held)):
            agent.brake()
        if not judge.stuck:
            self._stuck.discard(name)
        elif name not in self._stuck:
            self._stuck.add(name)
            self._sink.emit(Stuck(t=t, agent=name, reason=judge.stuck, rule=judge.stuck_rule))


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
            if registered_devices(spec.driver) is None:
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
