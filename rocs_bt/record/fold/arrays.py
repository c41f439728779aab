"""Events and signals of a recording as numpy structured arrays."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from ...base.errors import InputError, unknown
from ...event import Event, unpack
from ..file import codec
from ..file.header import AgentInfo, SignalInfo
from ..file.recording import Recording
from .samples import SAMPLE_TOPICS, environment_of, samples
from .tracks import Tracks

Table = NDArray[np.void]

_KINDS = {kind.__name__: kind for kind in codec.KINDS}
_DTYPES: dict[object, type[np.generic]] = {
    bool: np.bool_,
    int: np.int64,
    float: np.float64,
    float | None: np.float64,
    str: np.str_,
}


def event_table(recording: Recording, kind: str | type[Event] = "", agent: str | None = None) -> Table:
    """Events as a structured array, one row per event, in their order.

    The fields are `time` [s], `agent` and `event` (the type of the event). If one type of event is requested, the table
    also has the fields of this type, in SI units; the classes in `rocs_bt.event` document them. The dtypes follow the
    declared types: float64, int64, bool, `U` for texts; a number that is None is NaN. Packed values (`data` of
    SensorRead, `wheels` of BodyMoved) are subarrays of float64 if all rows have the same length. All other values are
    objects.

    Args:
        recording: The recording.
        kind: Type of event, or its name; all types if empty.
        agent: Name of the agent; all agents and the world if None.

    Raises:
        InputError: Unknown type of event, or unknown agent.
        RecordingError: The recording cannot be read.
    """
    name = kind if isinstance(kind, str) else kind.__name__
    if name and name not in _KINDS:
        raise InputError(unknown("type of event", name, _KINDS))
    if agent is not None:
        _agent(recording, agent)
    rows = (event for event in recording.events([_KINDS[name]] if name else ()) if agent in (None, event.agent))
    if not name:  # without their fields, because a long run does not fit into memory
        return _joined(_heads((event.t, event.agent, type(event).__name__) for event in rows))
    events = list(rows)
    columns = _heads((event.t, event.agent, name) for event in events)
    for field in msgspec.structs.fields(_KINDS[name]):
        if field.name not in ("t", "agent"):
            columns[field.name] = _column(field.type, [getattr(event, field.name) for event in events])
    return _joined(columns)


def _heads(heads: Iterable[tuple[float, str, str]]) -> dict[str, NDArray[Any]]:
    """Columns that all tables of events have."""
    t, agents, kinds = zip(*heads, strict=True) if (heads := list(heads)) else ((), (), ())
    return {"time": np.array(t, np.float64), "agent": np.array(agents, np.str_), "event": np.array(kinds, np.str_)}


def signal_table(recording: Recording, agent: str, names: Sequence[str] = ()) -> Table:
    """Signals of an agent as a structured array, one row per control period.

    The fields are `time` [s] and one per signal: float64, or a subarray of float64 for a signal of several values; a
    value that was stale or invalid is NaN. `dtype.metadata["units"]` maps each field to its unit.

    Args:
        recording: The recording.
        agent: Name of the agent.
        names: Names of the signals; all signals of the agent if empty.

    Raises:
        InputError: Unknown agent or signal.
        RecordingError: The recording cannot be read, or does not declare the agent's signals.
    """
    info = _agent(recording, agent)
    slices: dict[str, tuple[int, SignalInfo]] = {}
    at = 0
    for signal in info.signals:
        slices[signal.name] = at, signal
        at += signal.size
    for name in names:
        if name not in slices:
            raise InputError(unknown("signal", name, slices, f"The agent '{agent}'"))
    environment_of(info)
    times, values = samples(Tracks.of_recording(recording, SAMPLE_TOPICS), info)
    columns, units = {"time": np.array(times, np.float64)}, {"time": "s"}
    for name in names or slices:
        first, signal = slices[name]
        part = values[:, first : first + signal.size]
        columns[name] = part[:, 0] if signal.size == 1 else part
        units[name] = signal.units[0] if len(set(signal.units)) == 1 else ", ".join(signal.units)
    return _joined(columns, {"units": units})


def _agent(recording: Recording, name: str) -> AgentInfo:
    agents = {info.name: info for info in recording.header.agents}
    if name not in agents:
        raise InputError(unknown("agent", name, agents, "The run"))
    return agents[name]


def _column(declared: object, values: list[Any]) -> NDArray[Any]:
    """Values of one field, with the dtype of the field's declared type."""
    if declared in _DTYPES:
        return np.array(values, _DTYPES[declared])  # None becomes NaN
    if declared is bytes:
        values = [np.array(unpack(value)) for value in values]
        if len({len(value) for value in values}) == 1:
            return np.stack(values)
    column = np.empty(len(values), object)
    for row, value in enumerate(values):
        column[row] = value
    return column


def _joined(columns: dict[str, NDArray[Any]], metadata: Mapping[str, Any] = {}) -> Table:
    fields = [(name, column.dtype, column.shape[1:]) for name, column in columns.items()]
    table = np.empty(len(columns["time"]), np.dtype(fields, metadata=dict(metadata)))
    for name, column in columns.items():
        table[name] = column
    return table
