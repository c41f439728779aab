"""Driving: the minds of a scenario on robots that are real, or stand in for one; nothing is simulated.

The same missions, rules, blocks and rates as in simulation. What differs is each robot's table of drivers, whose
classes (`driver = "file.py:Class"`) speak with the robot.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass

from ..agent import Agent, RuleWatch, ThreadedRunner
from ..catalog import ActuatorSpec, Catalog, RobotSpec, ScenarioSpec
from ..clock import WallClock
from ..device import Actuator, Sensor
from ..drivers.host import Host
from ..drivers.isolated import IsolatedActuator
from ..event import EventSink, Fanout, NullSink
from ..safety import SafetyGate
from .devices import make_hardware, make_isolated
from .minds import build_minds
from .sink_thread import SinkThread


@dataclass(frozen=True)
class Driven:
    """What came of one agent.

    Attributes:
        status: Its mission's: `SUCCESS`, `FAILURE`, or `RUNNING` where time was up or somebody interrupted.
        reason: Why the mission, or a block, failed; empty while nothing did.
    """

    status: str
    reason: str


def drive(
    scenario: ScenarioSpec | str,
    catalog: Catalog | None = None,
    *,
    duration: float | None = None,
    sinks: Sequence[EventSink] = (),
    watch_rules: bool = False,
) -> dict[str, Driven]:
    """Let the minds of a scenario drive their robots, threaded, on wall time; movers and the world are not played.

    It ends when every mission has ended or failed, when time is up, or on Ctrl-C; the wheels stand then.

    Args:
        scenario: A scenario, or its name or file. Every driver of its agents' robots must be a class of their own.
        catalog: Where content is found; the project around the current folder by default.
        duration: The longest it may take [s]; the scenario's own by default.
        sinks: Where events go.
        watch_rules: Whether rule files that change meanwhile are read anew.

    Returns:
        What came of each agent, by its name.

    Raises:
        InputError: Something in the content is wrong.
        DeviceError: A driver cannot reach its device.
    """
    catalog = catalog or Catalog.here()
    spec = catalog.load_scenario(scenario) if isinstance(scenario, str) else scenario
    clock, limit = WallClock(running=False), spec.duration if duration is None else duration
    period = spec.rate.control_rate.period
    target: EventSink = Fanout(*sinks) if sinks else NullSink()
    with ExitStack() as stack:
        sink = stack.enter_context(SinkThread(target))
        robots = {agent.name: catalog.load_robot(agent.robot) for agent in spec.agents}
        sensors: dict[str, dict[str, Sensor]] = {}
        actuators: dict[str, dict[str, SafetyGate]] = {}
        links: dict[str, list[IsolatedActuator]] = {}
        for name, robot in robots.items():
            host = Host(clock)
            stack.callback(host.close)
            sensors[name] = {s.name: make_hardware(catalog, robot, s, host) for s in robot.sensors}
            devices = {a.name: _actuator(catalog, robot, a, host, stack) for a in robot.actuators}
            links[name] = [device for device in devices.values() if isinstance(device, IsolatedActuator)]
            actuators[name] = {a.name: a.guard(devices[a.name], clock, period, sink, name) for a in robot.actuators}
        rates = {n: {s.name: spec.rate.sensor_rate(s.rate, s.name) for s in r.sensors} for n, r in robots.items()}
        minds = build_minds(
            spec, catalog, robots, sensors, actuators, rates, clock=clock, sink=sink, timer=time.perf_counter
        )
        for mind in minds:
            stack.callback(mind.close)
        if watch_rules:
            stack.enter_context(RuleWatch([(m.name, file) for m in minds for file in m.rule_files], clock, sink))
        gates = [gate for each in actuators.values() for gate in each.values()]
        _play(minds, gates, [(mind, link) for mind in minds for link in links[mind.name]], clock, limit, period)
    return {mind.name: Driven(mind.status, mind.reason) for mind in minds}


def _play(
    minds: Sequence[Agent],
    gates: Sequence[SafetyGate],
    links: Sequence[tuple[Agent, IsolatedActuator]],
    clock: WallClock,
    limit: float,
    period: float,
) -> None:
    never, count = threading.Event(), 0
    clock.start()
    with ExitStack() as stack:
        for mind in minds:
            stack.enter_context(ThreadedRunner(mind, clock))
        try:
            while clock.wait_until(count * period, never) and clock.now() < limit:
                for gate in gates:
                    gate.check()
                for mind, link in links:
                    if (failed := link.check()) is not None:
                        mind.fail(f"actuator {link.name}", *failed)
                if all(mind.status != "RUNNING" or mind.failure is not None for mind in minds):
                    break
                count = max(count + 1, int(clock.now() / period) + 1)
        except KeyboardInterrupt:  # a person's way to end it: what is above stops the wheels on the way out
            pass


def _actuator(catalog: Catalog, robot: RobotSpec, spec: ActuatorSpec, host: Host, stack: ExitStack) -> Actuator:
    """An actuator's device; of an isolated one the link to its process, which ends with `stack` whatever happens."""
    if not spec.isolated:
        device: Actuator = make_hardware(catalog, robot, spec, host)
        return device
    return stack.enter_context(closing(make_isolated(catalog, robot, spec)))
