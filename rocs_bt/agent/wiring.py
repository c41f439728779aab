"""Builds and connects the monitors and analysers of robot.toml, and declares their signals (paper, 5.2)."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

from ..analyze import ANALYZERS, Analyze
from ..base.clock import Rate
from ..base.errors import Fault, InputError, located_at, unknown
from ..base.raised import content_line
from ..catalog import AnalyzeSpec, MonitorSpec, RobotSpec, is_reference, running_class
from ..declare import Declared, fields_of, read_arguments
from ..event import EventSink
from ..interfaces.device import Sensor
from ..knowledge import Knowledge
from ..monitor import MONITORS, Monitor, MonitoredSensor

T = TypeVar("T", bound=Declared)
LoadClass = Callable[[Path, str], type]


def make_monitors(
    robot: RobotSpec,
    knowledge: Knowledge,
    sensors: Mapping[str, Sensor],
    rates: Mapping[str, Rate],
    sink: EventSink,
    load_class: LoadClass,
) -> list[Monitor]:
    """Construct the monitors that robot.toml declares, with their sensors, in the order of the file.

    Raises:
        InputError: A class or sensor is unknown, parameters are wrong, or a sensor has another number of values than
            its monitor expects.
    """
    monitors, devices = [], {s.name: s for s in robot.sensors}
    for spec in robot.monitors:
        monitored = [
            MonitoredSensor(sensors[name], rate, device.validity(rate.period), device.optional, device.frame)
            for name in spec.sensors
            for rate, device in [(rates[name], devices[name])]
        ]
        with located_at(robot.file, spec.line):
            cls = _resolve(Monitor, spec.cls, MONITORS, robot, load_class)
        with located_at(robot.file, spec.line), running_class(cls):
            monitor = _make(cls, spec, monitored, knowledge, sink)
            for sensor, size in monitor.expects().items():
                if sensor not in spec.sensors:
                    raise InputError(unknown("sensor", sensor, spec.sensors, f"The monitor '{spec.name}'"))
                if devices[sensor].size not in (None, size):
                    raise InputError(
                        f"{spec.cls} '{spec.name}' expects {size} values from the sensor '{sensor}', which has "
                        f"{devices[sensor].size}. Make both equal."
                    )
        monitors.append(monitor)
    return monitors


def make_analyzers(
    robot: RobotSpec,
    knowledge: Knowledge,
    monitors: Sequence[Monitor],
    sink: EventSink,
    load_class: LoadClass,
) -> list[Analyze]:
    """Construct the analysers and connect them to their monitors.

    Analysers that write signals come first in the result, because the others may read these signals.

    Raises:
        InputError: A class or signal is unknown, or parameters are wrong.
    """
    analyzers: list[Analyze] = []
    for spec in robot.analyzers:
        with located_at(robot.file, spec.line):
            cls = _resolve(Analyze, spec.cls, ANALYZERS, robot, load_class)
        with located_at(robot.file, spec.line), running_class(cls):
            analyzers.append(_make(cls, spec, knowledge, sink))
    found = {signal for analyze in analyzers for signal in _written(analyze)}
    by_name = {monitor.name: monitor for monitor in monitors}
    written = {name: _written(monitor) for name, monitor in by_name.items()}
    for spec, analyze in zip(robot.analyzers, analyzers, strict=True):
        heard = [signal for monitor in spec.monitors for signal in written[monitor]]
        with running_class(type(analyze)):
            missed = [name for name in analyze.expects() if name not in heard]
        if odd := [name for name in missed if not isinstance(name, str)]:
            message = f"'{spec.name}' must declare the names of its input signals, found {odd[0]!r:.40}."
            raise InputError(Fault(message, robot.file, spec.line))
        if unheard := [name for name in missed if name not in found]:
            where = f"The input of '{spec.name}'"
            raise InputError(*(unknown("signal", n, heard, where).at(robot.file, spec.line) for n in unheard))
        analyze.from_knowledge = tuple(missed)
        for monitor in spec.monitors:
            by_name[monitor].attach(analyze)
    return sorted(analyzers, key=lambda analyze: not analyze.signals())


def declare_signals(knowledge: Knowledge, writers: Sequence[Monitor | Analyze], robot: RobotSpec) -> None:
    """Declare the signals that monitors and analysers write, which fixes the layout of a snapshot.

    Raises:
        InputError: Two blocks write the same signal, or a sensor in robot.toml names a signal that no block writes.
    """
    lines = {f"monitor '{m.name}'": m.line for m in robot.monitors}
    lines |= {f"analyze '{a.name}'": a.line for a in robot.analyzers}
    first: dict[str, str] = {}
    for writer in writers:
        block = f"{'monitor' if isinstance(writer, Monitor) else 'analyze'} '{writer.name}'"
        with located_at(robot.file, lines.get(block, 0)), running_class(type(writer)):
            for signal in writer.signals():
                if (other := first.setdefault(signal.name, block)) != block:
                    raise InputError(
                        f"the {other} and the {block} both write the signal '{signal.name}'. Remove one of them."
                    )
                knowledge.signals.declare(signal)
    known = knowledge.signals.names
    faults = [
        unknown("signal", s.signal, known, "The robot").at(robot.file, s.line)
        for s in robot.sensors
        if s.signal not in known
    ]
    if faults:
        raise InputError(*faults)
    knowledge.signals.freeze()


def _written(block: Monitor | Analyze) -> list[str]:
    """Names of the signals that a monitor or an analyser writes."""
    with running_class(type(block)):
        return [signal.name for signal in block.signals()]


def _resolve(base: Any, name: str, table: Mapping[str, type[T]], robot: RobotSpec, load_class: LoadClass) -> type[T]:
    """Find the class of a block: a shipped one by name, or a user's by `file.py:Class`, relative to robot.toml."""
    if not is_reference(name):
        return table[name]
    file, _, cls = name.partition(":")
    found = load_class(robot.beside(file), cls)
    if not issubclass(found, base):
        raise InputError(f"the class '{cls}' does not extend rocs_bt.{base.__name__}.")
    return found


def _make(cls: type[T], spec: MonitorSpec | AnalyzeSpec, *passed: Any) -> T:
    """Construct a monitor or an analyser from its table; `passed` are the other positional arguments."""
    what = f"{cls.__name__} '{spec.name}'"
    given = read_arguments({each.key: each for each in fields_of(cls)}, spec.parameters, what)
    make: Callable[..., T] = cls
    try:
        return make(spec.name, *passed, **given)
    except (TypeError, ValueError, OverflowError) as error:  # refused by the constructor itself
        if content_line(error) is not None:  # raised in a user's class
            raise
        raise InputError(f"{what} does not take these parameters: {error}.") from error
