"""HardwareStage: a run on the robots themselves.

Missions, rules, blocks and rates are the same as in simulation. Only the drivers in each robot.toml differ: classes of
the user (`driver = "file.py:Class"`) that communicate with the robot. Without ground truth, the outcomes are determined
from the robots' own estimates.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from functools import partial

from ..agent import Agent, Runtime, ThreadedRunner
from ..agent.lateness import load
from ..base.clock import wait_until
from ..catalog import Catalog, ScenarioSpec
from ..drivers.isolated import IsolatedActuator
from ..drivers.last_neutral import repeat_neutral
from ..event import BodyMoved, EventSink, Stuck
from ..simulation.outcome import Judge
from .build_agents import build_agents
from .episode import brake
from .hardware_devices import HardwareDevices, hardware_clock
from .hardware_services import WatchedClock
from .options import RunOptions
from .preflight import Preflight, preflight_sensors


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
        runtime = Runtime(self.clock, self._sink, time.perf_counter)
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
