"""Preflight check of a run on hardware: the robots stay in neutral until every needed sensor gives fresh values."""

from __future__ import annotations

import math
import threading
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from functools import partial

import msgspec

from ..agent import Agent
from ..base.clock import WallClock, wait_until
from ..base.errors import DeviceError, interrupts
from ..base.raised import Raised
from ..base.words import counted
from ..catalog import RobotSpec, SensorSpec
from ..catalog.registered_devices import registered_devices
from ..interfaces.device import NOTABLE_AHEAD, Sensor
from .signal_sources import signal_monitors, signals_read

OBSERVED = 0.5
"""Minimum time from the first samples to the start, in which the rates are measured [s]."""

LOOK = 0.2
"""Interval at which the nodes at the other side are looked for [s]."""

_SAMPLES = 40  # number of newest samples over which a rate is measured
_SOURCES = ("topic", "topics", "address", "port", "device")  # keys of a driver that say where the values come from
_STILL_FRESH = 5e-7  # [s] rounding tolerance, as in Monitor


class SensorState(msgspec.Struct, frozen=True, kw_only=True):
    """State of a sensor, or of a topic that needs a node at the other side, before the start.

    Attributes:
        agent: Name of the agent.
        sensor: Name of the sensor or actuator, or key of the `[ros2]` table.
        driver: Driver, as in robot.toml.
        source: Full topic, address or port from which the driver reads; empty if robot.toml has none.
        rate: Measured rate of new samples [Hz]; None before the second sample.
        declared_rate: Rate at which the sensor will be read [Hz].
        age: Age of the newest sample [s]; None without a sample.
        size: Number of values of the newest sample; for a topic, of matching nodes.
        problem: Reason why the values are not usable, such as `no sample: ...`; empty if they are fresh.
        needed_for: Uses of the sensor's signals, such as `pose` and the rule files; empty if the engine knows of none.
        optional: Whether the robot may start without it.
        matched: Whether it is a topic with a number of matching nodes.
        ahead: Notable time by which the publisher's clock is ahead of that of this computer [s]; 0 without one.
    """

    agent: str
    sensor: str
    driver: str
    source: str
    needed_for: tuple[str, ...]
    optional: bool
    rate: float | None = None
    declared_rate: float = 0.0
    age: float | None = None
    size: int = 0
    problem: str = ""
    matched: bool = False
    ahead: float = 0.0

    @property
    def blocks(self) -> bool:
        """Whether the robots must not start because of this sensor."""
        return bool(self.problem) and not self.optional


class PreflightReport(msgspec.Struct, frozen=True, kw_only=True):
    """State of all sensors before the start.

    Attributes:
        t: Time since the beginning of the preflight check [s].
        sensors: States of the sensors, in the order of the agents and of robot.toml.
        paused: Reason why the robots must not start although their sensors are fresh; empty without one.
        over: Whether this is the last report, so that the robots start, or the check has failed.
    """

    t: float
    sensors: tuple[SensorState, ...]
    paused: str = ""
    over: bool = False

    @property
    def missing(self) -> tuple[SensorState, ...]:
        """Sensors because of which the robots must not start."""
        return tuple(state for state in self.sensors if state.blocks)


class PreflightSensor:
    """Sensor that is observed before the start.

    Args:
        sensor: Device.
        known: Its state without samples.
        max_age: Age up to which a sample is fresh [s].
    """

    def __init__(self, sensor: Sensor, known: SensorState, max_age: float) -> None:
        self._sensor = sensor
        self._known = known
        self._max_age = max_age
        self._stamps: deque[float] = deque(maxlen=_SAMPLES)

    def state(self, now: Callable[[], float]) -> SensorState:
        """Read the sensor and check the sample.

        Args:
            now: Function that returns the present time on the clock of the stamps [s].
        """
        age, size, problem = self._read(now)
        ahead = self._sensor.clock_ahead
        span = self._stamps[-1] - self._stamps[0] if len(self._stamps) > 1 else 0.0
        return msgspec.structs.replace(
            self._known,
            rate=(len(self._stamps) - 1) / span if span > 0.0 else None,
            age=age,
            size=size,
            problem=problem,
            ahead=ahead if ahead >= NOTABLE_AHEAD else 0.0,
        )

    def _read(self, now: Callable[[], float]) -> tuple[float | None, int, str]:
        """Age of the newest sample [s], number of its values, and the reason why they are not usable."""
        try:
            reading = self._sensor.read()
            stamp, values = reading.stamp, list(map(float, reading.values))
        except DeviceError as error:
            return None, 0, f"no sample: {error}"
        except BaseException as error:  # a driver may raise anything
            if interrupts(error):
                raise
            return None, 0, f"exception: {Raised.of('sensor', self._known.sensor, error, self._sensor.read)}"
        if not self._stamps or stamp > self._stamps[-1]:
            self._stamps.append(stamp)
        age, invalid = now() - stamp, sum(map(math.isnan, values))
        if not -self._max_age <= age <= self._max_age + _STILL_FRESH:  # also a stamp that is NaN
            when = f"{age:.2f} s old" if age >= 0.0 else f"stamped {-age:.2f} s in the future"
            return age, len(values), f"stale: its newest sample is {when}; allowed are {self._max_age:.2f} s"
        problem = f"{invalid} of {counted(len(values), 'value')} NaN" if invalid else ""
        return age, len(values), problem


class PreflightTopic:
    """Topic that needs a node at the other side: one for commands, or of an emergency stop."""

    def __init__(self, known: SensorState, look: Callable[[], tuple[int, str]]) -> None:
        self._look = look
        self._found = known
        self._looked = -math.inf

    def state(self, now: Callable[[], float]) -> SensorState:
        """Look for the nodes, at most once per `LOOK`; see `PreflightSensor.state`."""
        if (present := now()) - self._looked >= LOOK:
            self._looked = present
            size, problem = self._look()
            self._found = msgspec.structs.replace(self._found, size=size, problem=problem)
        return self._found


class Preflight:
    """Check of all sensors before the robots may move.

    Args:
        sensors: Sensors of all robots, and topics that need a node at the other side.
        clock: Clock of the sensors' stamps, running.
        period: Interval between two checks [s].
        wait: Time for which needed sensors may be missing [s].
        show: Observer, called at each check; None for none.
    """

    def __init__(
        self,
        sensors: Sequence[PreflightSensor | PreflightTopic],
        clock: WallClock,
        period: float,
        *,
        wait: float,
        show: Callable[[PreflightReport], None] | None = None,
    ) -> None:
        self._sensors = sensors
        self._clock = clock
        self._period = period
        self._wait = wait
        self._show = show or (lambda report: None)

    def run(self, ended: Callable[[], str], paused: Callable[[bool], str] = lambda ready: "") -> bool:
        """Wait until all needed sensors are fresh and nothing else prevents the start.

        Args:
            ended: Returns the reason of a signal that ends the run, or an empty text.
            paused: Returns the reason why the robots must not start yet, such as an emergency stop, or an empty text.
                It is called at each check with whether all needed sensors are fresh, and while the clock is stopped.

        Returns:
            Whether the robots may start; False if a signal ended the run.

        Raises:
            DeviceError: A needed sensor was not fresh for the whole time `wait`; names all such sensors and reasons.
            Exception: An exception of `paused`.
        """
        begun = fresh = self._clock.now()
        complete = math.inf  # [s] time at which all needed sensors were fresh for the first time
        never = threading.Event()
        while not ended():
            states, now = tuple(sensor.state(self._clock.now) for sensor in self._sensors), self._clock.now()
            present = not any(state.blocks for state in states)
            complete = min(complete, now) if present else complete
            fit = present and now - complete >= OBSERVED
            report = PreflightReport(t=now - begun, sensors=states, paused=paused(fit))
            if not report.missing:
                fresh = now
                if fit and not report.paused:
                    self._show(msgspec.structs.replace(report, over=True))
                    return True
            elif now - fresh >= max(self._wait, OBSERVED):
                self._show(msgspec.structs.replace(report, over=True))
                raise DeviceError(_refusal(report.missing, self._wait))
            self._show(report)
            due = now + 0.5 * self._period  # twice the rate, to count all samples
            wait_until(self._clock, due, never, ended, partial(paused, fit))
        return False


def preflight_sensors(agent: Agent, robot: RobotSpec) -> list[PreflightSensor]:
    """Sensors of an agent for the preflight check, in the order of robot.toml."""
    uses, found = _uses(agent, robot), {}
    for monitor in agent.monitors:
        for monitored in monitor.monitored:
            name = monitored.sensor.name
            spec = next(each for each in robot.sensors if each.name == name)
            known = SensorState(
                agent=agent.name,
                sensor=name,
                driver=spec.driver,
                source=_source(spec, robot),
                declared_rate=monitored.rate.hz,
                needed_for=tuple(uses.get(monitor.name, ())),
                optional=spec.optional,
            )
            found[name] = PreflightSensor(monitored.sensor, known, monitor.max_age)
    return [found[spec.name] for spec in robot.sensors if spec.name in found]


def _uses(agent: Agent, robot: RobotSpec) -> Mapping[str, list[str]]:
    """Uses of each monitor's signals, directly or through analysers: `pose`, and the rule files that read them."""
    sources, reads = signal_monitors(agent, robot), {"pose": {"pose"}}
    for file in agent.reloadable_rules:
        nodes = (node for rule in file.model.rules.rules for node in rule.nodes())
        reads[file.model.rules.name] = signals_read(nodes, agent.knowledge)
    uses: dict[str, list[str]] = {}
    for use, names in reads.items():
        for monitor in dict.fromkeys(monitor for name in names for monitor in sources.get(name, ())):
            uses.setdefault(monitor, []).append(use)
    return uses


def _source(spec: SensorSpec, robot: RobotSpec) -> str:
    """Text of where a sensor's values come from: the first of the keys `_SOURCES`; topics with their full names."""
    given = spec.arguments
    found = next((given[key] for key in _SOURCES if given.get(key)), "")
    names = [str(name) for name in (found if isinstance(found, (list, tuple)) else [found])]
    devices = registered_devices(spec.driver)
    return ", ".join(names if devices is None else (devices.source(robot, name) for name in names))


def _refusal(missing: Sequence[SensorState], wait: float) -> str:
    reasons = "".join(f"\n  {state.agent}/{state.sensor}: {state.problem}" for state in missing)
    if all(state.matched for state in missing):
        return f"the robots were not started: topics without a matching node for {wait:g} s.{reasons}"
    those = "it" if len(missing) == 1 else "all"
    return (
        f"the robots were not started: {counted(len(missing), 'needed sensor')} without fresh values for {wait:g} s."
        f"{reasons}\nConnect {those}, or declare a sensor that the mission does not need as optional in robot.toml: "
        "optional = true."
    )
