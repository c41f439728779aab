"""Devices that fail on purpose, to try what a robot does then.

from rocs_bt.testing.faults import DeadSensor, break_sensor

def test_a_robot_without_sonar_stands_still():
    result = run("exp1", prepare=lambda stage: break_sensor(stage, "sonar", DeadSensor, at=3.0))
    assert result.summary.agents["R2"].collisions == 0
"""

from __future__ import annotations

import math
import threading
from abc import abstractmethod
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from ..clock import Clock
from ..device import Actuator, Reading, Sensor
from ..errors import DeviceError, Fault, InputError, unknown

if TYPE_CHECKING:
    from ..simulation import SimulatedWorld


class FaultySensor(Sensor):
    """A sensor that works until its time has come; the base of those below.

    Args:
        sensor: The sensor that works.
        clock: Time.
        at: From when on it is broken [s].
        until: From when on it works again [s].
    """

    def __init__(self, sensor: Sensor, clock: Clock, *, at: float = 0.0, until: float = math.inf) -> None:
        super().__init__(sensor.name)
        self.sensor = sensor
        self._clock = clock
        self._at = at
        self._until = until

    def read(self) -> Reading:
        now = self._clock.now()
        return self.broken() if self._at <= now < self._until else self.works()

    def works(self) -> Reading:
        """A sample while it works."""
        return self.sensor.read()

    @abstractmethod
    def broken(self) -> Reading:
        """A sample, or whatever there is instead, while it is broken."""

    def close(self) -> None:
        self.sensor.close()


class DeadSensor(FaultySensor):
    """A sensor that refuses to be read."""

    def broken(self) -> Reading:
        raise DeviceError(f"sensor '{self.name}' does not answer.")


class RaisingSensor(FaultySensor):
    """A sensor whose driver has a defect: it raises something else than DeviceError."""

    def broken(self) -> Reading:
        raise RuntimeError(f"the driver of '{self.name}' has a defect")


class FrozenSensor(FaultySensor):
    """A sensor that repeats its last sample.

    Args:
        fresh: True: with a new stamp each time, so that only the values tell. False: the old stamp too.
        fault: As for every FaultySensor.
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
    """A sensor that says one value, such as NaN or 1e12, whatever it measures.

    Args:
        value: What it says.
        index: Which of its values; None for all.
        fault: As for every FaultySensor.
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
    """A sensor whose driver does not return; for threaded mode.

    Args:
        release: Set it to let go of whoever hangs.
        fault: As for every FaultySensor.
    """

    def __init__(self, *args: Any, release: threading.Event | None = None, **fault: Any) -> None:
        super().__init__(*args, **fault)
        self.release = release or threading.Event()

    def broken(self) -> Reading:
        self.release.wait()
        return self.sensor.read()


class FaultyActuator(Actuator):
    """An actuator that works until its time has come; the base of those below. It still goes to neutral.

    Args:
        actuator: The actuator that works.
        clock: Time.
        at: From when on it is broken [s].
        until: From when on it works again [s].
    """

    def __init__(self, actuator: Actuator, clock: Clock, *, at: float = 0.0, until: float = math.inf) -> None:
        super().__init__(actuator.name, actuator.size)
        self.actuator = actuator
        self._clock = clock
        self._at = at
        self._until = until

    def command(self, values: Sequence[float]) -> None:
        if self._at <= self._clock.now() < self._until:
            self.broken(values)
        else:
            self.actuator.command(values)

    @abstractmethod
    def broken(self, values: Sequence[float]) -> None:
        """A command while it is broken."""

    def neutral(self) -> None:
        self.actuator.neutral()

    def close(self) -> None:
        self.actuator.close()


class RefusingActuator(FaultyActuator):
    """An actuator that refuses every command."""

    def broken(self, values: Sequence[float]) -> None:
        raise DeviceError(f"actuator '{self.name}' does not answer.")


class RaisingActuator(FaultyActuator):
    """An actuator whose driver has a defect: it raises something else than DeviceError."""

    def broken(self, values: Sequence[float]) -> None:
        raise RuntimeError(f"the driver of '{self.name}' has a defect")


class HangingActuator(FaultyActuator):
    """An actuator that takes a command and then does not return; for threaded mode.

    Args:
        release: Set it to let go of whoever hangs; the command then goes on to the device.
        fault: As for every FaultyActuator.
    """

    def __init__(self, *args: Any, release: threading.Event | None = None, **fault: Any) -> None:
        super().__init__(*args, **fault)
        self.release = release or threading.Event()

    def broken(self, values: Sequence[float]) -> None:
        self.release.wait()
        self.actuator.command(values)


def break_sensor(
    stage: SimulatedWorld, name: str, fault: Callable[..., Sensor], agent: str = "", **parameters: Any
) -> None:
    """Put a broken sensor in the place of a good one; for `rocs_bt.run(..., prepare=...)`.

    Args:
        stage: The stage that `prepare` is given.
        name: The sensor.
        fault: Such as `DeadSensor`.
        agent: Whose; the only agent that has it when left out.
        parameters: What the fault takes, such as `at=3.0`.

    Raises:
        InputError: Nobody has that sensor, or several do and no agent was named.
    """
    sensors = stage.sensors[_whose(agent, name, {a: list(found) for a, found in stage.sensors.items()}, "sensor")]
    sensors[name] = fault(sensors[name], stage.clock, **parameters)


def break_actuator(
    stage: SimulatedWorld, name: str, fault: Callable[..., Actuator], agent: str = "", **parameters: Any
) -> None:
    """Put a broken actuator behind the safety gate in place of a good one; see `break_sensor`."""
    owner = _whose(agent, name, {a: list(found) for a, found in stage.actuators.items()}, "actuator")
    stage.actuators[owner][name].wrap(lambda device: fault(device, stage.clock, **parameters))


def _whose(agent: str, name: str, devices: dict[str, list[str]], kind: str) -> str:
    owners = [a for a, names in devices.items() if name in names and agent in ("", a)]
    if not owners:
        known = {n for a, names in devices.items() if agent in ("", a) for n in names}
        raise InputError(unknown(kind, name, known, f"The agent '{agent}'" if agent else "The stage"))
    if len(owners) > 1:
        raise InputError(Fault(f"{', '.join(owners)} have a {kind} '{name}' each.", hint="Say whose with agent=."))
    return owners[0]
