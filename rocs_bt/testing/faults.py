"""Fault injection: sensors and actuators that fail during a run.

from rocs_bt.testing.faults import DeadSensor, break_sensor

def test_a_robot_without_sonar_stands_still():
    result = run("exp1", prepare=lambda world: break_sensor(world, "sonar", DeadSensor, at=3.0))
    assert result.summary.agents["R2"].collisions == 0
"""

from __future__ import annotations

import math
import threading
from abc import abstractmethod
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from ..base.clock import Clock
from ..base.errors import DeviceError, Fault, InputError, unknown
from ..event import ScriptActed
from ..interfaces.device import Actuator, Reading, Sensor

if TYPE_CHECKING:
    from ..simulation import SimulatedWorld

Announce = Callable[[str, float | None], None]
"""Reports that a fault begins: name of its class, and its end [s] or None."""


class _Faulty:
    """Device that fails during an interval; `announce` is called once, when the fault begins."""

    announce: Announce | None = None
    _clock: Clock
    _at: float
    _until: float

    @property
    def _fails(self) -> bool:
        fails = self._at <= self._clock.now() < self._until
        announce = self.announce
        if fails and announce is not None:
            self.announce = None  # before the call, so that there is one, also if it raises
            announce(type(self).__name__, self._until if math.isfinite(self._until) else None)
        return fails


class FaultySensor(_Faulty, Sensor):
    """Base class of faulty sensors: a working sensor that fails during an interval.

    Args:
        sensor: Sensor to read outside the interval.
        clock: Clock of the interval.
        at: Start of the fault [s].
        until: End of the fault [s].
    """

    def __init__(self, sensor: Sensor, clock: Clock, *, at: float = 0.0, until: float = math.inf) -> None:
        super().__init__(sensor.name)
        self.sensor = sensor
        self._clock, self._at, self._until = clock, at, until

    def read(self) -> Reading:
        return self.broken() if self._fails else self.works()

    def works(self) -> Reading:
        """Return the reading outside the fault's interval."""
        return self.sensor.read()

    @abstractmethod
    def broken(self) -> Reading:
        """Return the reading during the fault, or raise its exception."""

    def close(self) -> None:
        self.sensor.close()


class DeadSensor(FaultySensor):
    """Sensor that raises DeviceError when read."""

    def broken(self) -> Reading:
        raise DeviceError(f"sensor '{self.name}' does not answer.")


class RaisingSensor(FaultySensor):
    """Sensor with a driver bug: it raises an exception other than DeviceError."""

    def broken(self) -> Reading:
        raise RuntimeError(f"the driver of '{self.name}' has a defect")


class FrozenSensor(FaultySensor):
    """Sensor that repeats its last reading.

    Args:
        fresh: Whether each repeated reading gets the present time as its stamp, so that only its constant values show
            the fault.
        fault: Arguments of FaultySensor.
    """

    def __init__(self, *args: Any, fresh: bool = False, **fault: Any) -> None:
        super().__init__(*args, **fault)
        self._fresh = fresh
        self._last: Reading | None = None

    def works(self) -> Reading:
        self._last = self.sensor.read()
        return self._last

    def broken(self) -> Reading:
        last = self._last or self.works()
        return Reading(self._clock.now(), last.values) if self._fresh else last


class LyingSensor(FaultySensor):
    """Sensor with its values replaced by a constant, such as NaN or 1e12.

    Args:
        value: The constant, in the unit of the sensor's values.
        index: Index of the replaced value in the reading; None for all values.
        fault: Arguments of FaultySensor.
    """

    def __init__(self, *args: Any, value: float = math.nan, index: int | None = None, **fault: Any) -> None:
        super().__init__(*args, **fault)
        self._value = value
        self._index = index

    def broken(self) -> Reading:
        reading = self.sensor.read()
        values = [self._value if self._index in (None, i) else v for i, v in enumerate(reading.values)]
        return Reading(reading.stamp, values)


class HangingSensor(FaultySensor):
    """Sensor with a driver that blocks; for threaded mode.

    Args:
        release: Event that ends the blocking.
        fault: Arguments of FaultySensor.
    """

    def __init__(self, *args: Any, release: threading.Event | None = None, **fault: Any) -> None:
        super().__init__(*args, **fault)
        self.release = release or threading.Event()

    def broken(self) -> Reading:
        self.release.wait()
        return self.sensor.read()


class FaultyActuator(_Faulty, Actuator):
    """Base class of faulty actuators: a working actuator that fails during an interval; its `neutral` always works.

    Args:
        actuator: Actuator that gets the commands outside the interval.
        clock: Clock of the interval.
        at: Start of the fault [s].
        until: End of the fault [s].
    """

    def __init__(self, actuator: Actuator, clock: Clock, *, at: float = 0.0, until: float = math.inf) -> None:
        super().__init__(actuator.name, actuator.size)
        self.actuator = actuator
        self._clock, self._at, self._until = clock, at, until

    def command(self, values: Sequence[float]) -> None:
        if self._fails:
            self.broken(values)
        else:
            self.actuator.command(values)

    @abstractmethod
    def broken(self, values: Sequence[float]) -> None:
        """Handle a command during the fault, instead of the working actuator."""

    def neutral(self) -> None:
        self.actuator.neutral()

    def close(self) -> None:
        self.actuator.close()


class RefusingActuator(FaultyActuator):
    """Actuator that raises DeviceError on every command."""

    def broken(self, values: Sequence[float]) -> None:
        raise DeviceError(f"actuator '{self.name}' does not answer.")


class RaisingActuator(FaultyActuator):
    """Actuator with a driver bug: it raises an exception other than DeviceError."""

    def broken(self, values: Sequence[float]) -> None:
        raise RuntimeError(f"the driver of '{self.name}' has a defect")


class HangingActuator(FaultyActuator):
    """Actuator that blocks on a command; for threaded mode.

    Args:
        release: Event that ends the blocking; the command then reaches the device.
        fault: Arguments of FaultyActuator.
    """

    def __init__(self, *args: Any, release: threading.Event | None = None, **fault: Any) -> None:
        super().__init__(*args, **fault)
        self.release = release or threading.Event()

    def broken(self, values: Sequence[float]) -> None:
        self.release.wait()
        self.actuator.command(values)


def _announcing(world: SimulatedWorld, agent: str, topic: str, kind: str, name: str) -> Announce:
    def announce(fault: str, until: float | None) -> None:
        what = f"{fault} breaks the {kind} {name}"
        world.sink.emit(ScriptActed(t=world.clock.now(), agent=agent, topic=topic, name=name, what=what, until=until))

    return announce


def break_sensor(
    world: SimulatedWorld, name: str, fault: Callable[..., Sensor], agent: str = "", **parameters: Any
) -> None:
    """Replace a sensor by a faulty one; call it in the `prepare` argument of `rocs_bt.run`.

    Args:
        world: Simulated world, the argument of `prepare`.
        name: Name of the sensor.
        fault: Fault class, such as `DeadSensor`.
        agent: Agent that has the sensor; may be omitted if only one agent has it.
        parameters: Arguments of the fault, such as `at=3.0`.

    Raises:
        InputError: No agent has the sensor, or several have it and `agent` is omitted.
    """
    owner = _owner(agent, name, {a: list(found) for a, found in world.sensors.items()}, "sensor")
    made = world.sensors[owner][name] = fault(world.sensors[owner][name], world.clock, **parameters)
    if isinstance(made, FaultySensor):
        made.announce = _announcing(world, owner, "sensor", "sensor", name)


def break_actuator(
    world: SimulatedWorld, name: str, fault: Callable[..., Actuator], agent: str = "", **parameters: Any
) -> None:
    """Replace an actuator behind its safety gate by a faulty one; see `break_sensor`."""
    owner = _owner(agent, name, {a: list(found) for a, found in world.actuators.items()}, "actuator")

    def broken(device: Actuator) -> Actuator:
        made = fault(device, world.clock, **parameters)
        if isinstance(made, FaultyActuator):
            made.announce = _announcing(world, owner, "command", "actuator", name)
        return made

    world.actuators[owner][name].wrap(broken)


def _owner(agent: str, name: str, devices: dict[str, list[str]], kind: str) -> str:
    owners = [a for a, names in devices.items() if name in names and agent in ("", a)]
    if not owners:
        known = {n for a, names in devices.items() if agent in ("", a) for n in names}
        raise InputError(unknown(kind, name, known, f"The agent '{agent}'" if agent else "The world"))
    if len(owners) > 1:
        raise InputError(Fault(f"{', '.join(owners)} each have a {kind} '{name}'.", hint="Choose one with agent=."))
    return owners[0]
