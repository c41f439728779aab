"""Lossless JSON encoding of events; topic and schema of each kind of event.

JSON has no NaN and no infinity, so msgspec writes null for these. A message with such numbers has an additional key,
`non_finite`. It contains the path of each such number and the eight bytes of the number in hexadecimal, so that sign
and payload of a NaN are preserved. Viewers can therefore read plain JSON, and `decode` restores the event bit by bit.
"""

from __future__ import annotations

import math
import operator
import struct
from collections.abc import Iterable, Mapping, Sequence
from functools import reduce
from typing import Any, cast

import msgspec
import numpy as np

from ... import event as ev
from ...base.errors import RecordingError
from ...base.nesting import check_nesting
from ...event import Event
from .wire import FORMS, Command, Reading, Signals, non_finite, restore

#: Kinds of events that can be decoded.
KINDS: tuple[type[Event], ...] = tuple(
    kind for kind in vars(ev).values() if isinstance(kind, type) and issubclass(kind, Event) and kind is not Event
)
# Other kinds use the class name as topic.
EVENT_TOPICS: dict[type[Event], str] = {
    ev.SensorRead: "sensors",
    ev.SensorFailed: "sensor_failures",
    ev.SignalsWritten: "signals",
    ev.Change: "changes",
    ev.KnowledgeChanged: "knowledge",
    ev.MapChanged: "map",
    ev.RuleChanged: "rules",
    ev.NodeTicked: "tree",
    ev.SubtreeSwapped: "swaps",
    ev.BlackboardChanged: "blackboard",
    ev.Replanned: "replans",
    ev.TicketChanged: "tickets",
    ev.AtomicStarted: "atomic_actions",
    ev.ActuatorCommanded: "commands",
    ev.FollowerStepped: "follower",
    ev.PathPlanned: "paths",
    ev.BlockFailed: "blocks",
    ev.ContentRaised: "exceptions",
    ev.BodyMoved: "poses",
    ev.ContactBegan: "contacts",
    ev.OutcomeDecided: "outcome",
}
SCHEMA_PREFIX = "rocs_bt."
#: Exceptions that encoding raises for an event with unsupported values.
UNFIT = (TypeError, ValueError, OverflowError, RecursionError, struct.error)
_WHOLE = frozenset((str, bytes, int, bool, type(None)))  # types that cannot contain a NaN


def topic_of(kind: type[Event], agent: str) -> str:
    """Topic of a kind of event: `/R2/tickets`, or `/world/poses` without an agent."""
    return f"/{agent or 'world'}/{EVENT_TOPICS.get(kind, kind.__name__)}"


def schema_of(event: Event | FORMS, signals: Iterable[tuple[str, int]] = ()) -> bytes:
    """JSON schema of the messages of a topic, with an object at its root, as viewers require."""
    kind = type(event)
    (schema,), components = msgspec.json.schema_components([kind], ref_template="#/$defs/{name}")
    schema = components.pop(kind.__name__)
    schema["properties"]["non_finite"] = {"type": "array", "items": {"type": "array"}}
    number = {"type": "number"}
    if isinstance(event, Command):
        schema["properties"]["values"] = {"type": "object", "properties": dict.fromkeys(event.values, number)}
    elif isinstance(event, Signals):
        sizes = {name: 2 if isinstance(value, list) else 1 for name, value in event.values.items()} | dict(signals)
        shapes = {name: number if size == 1 else {"type": "array", "items": number} for name, size in sizes.items()}
        schema["properties"]["values"] = {"type": "object", "properties": shapes}
    elif isinstance(event, Reading):
        schema["properties"]["values"] = {"type": "array", "items": number}
    return msgspec.json.encode({**schema, "$defs": components} if components else schema)


def plain(value: Any) -> Any:
    """Convert values that msgspec cannot encode: numpy numbers and arrays, and views of mappings."""
    if isinstance(value, (np.generic, np.ndarray)):
        return value.tolist()
    if isinstance(value, Mapping):
        return dict(value)
    raise TypeError(f"an event cannot contain a {type(value).__name__}")


_ENCODER = msgspec.json.Encoder(enc_hook=plain)
_ENCODE, _LINES = _ENCODER.encode, _ENCODER.encode_lines
_ANY: Any = reduce(operator.or_, KINDS) | FORMS
_DECODE = msgspec.json.Decoder(_ANY).decode
_NAMED = tuple(f'{{"event":"{form.__name__}"'.encode() for form in (Signals, Reading, Command))  # see wire.Incoming


def encode(event: Event | FORMS) -> bytes:
    """Encode an event, or the form of one, as JSON.

    Raises:
        TypeError: The event contains an object that is not plain data.
        ValueError: The event contains an invalid value, such as text that is not Unicode.
    """
    data = _ENCODE(event)
    # Most nulls are None; only for non-finite numbers are the bits added.
    return data if isinstance(event, FORMS) or b"null" not in data or _all_finite(event) else _exact(event)


def encode_all(events: Sequence[Event | FORMS]) -> list[bytes | None]:
    """Encode many events at once, which is faster; None for each event that must be encoded by `encode`."""
    try:
        lines = _LINES(events).split(b"\n")
    except UNFIT:  # raised again by `encode` for the event at fault
        return [None] * len(events)
    lines.pop()  # empty text after the last line break
    return [
        line if isinstance(event, FORMS) or b"null" not in line or _all_finite(event) else None
        for line, event in zip(lines, events, strict=True)
    ]


def decode(data: bytes) -> Event | FORMS:
    """Decode what `encode` has encoded.

    Raises:
        RecordingError: The message does not contain an event.
    """
    try:
        check_nesting(data)
        if b'"non_finite"' not in data or data.startswith(_NAMED):
            return cast(Event | FORMS, _DECODE(data))
        fields = msgspec.json.decode(data)
        restore(fields, fields.pop("non_finite", ()))
        return cast(Event | FORMS, msgspec.convert(fields, _ANY))
    except (msgspec.DecodeError, msgspec.ValidationError, TypeError, ValueError, AttributeError) as error:
        raise RecordingError(f"a message cannot be read back: {error}; it begins with {data[:80]!r}.") from error


def _all_finite(event: Event | FORMS) -> bool:
    """Whether an event has only finite numbers, so that each null in its JSON is a None."""
    return _finite(getattr(event, name) for name in event.__struct_fields__)


def _finite(values: Iterable[Any]) -> bool:
    """Whether all numbers in the values are finite; also False for a value of a type that is not inspected."""
    for value in values:
        kind = type(value)
        if kind is float:
            if not math.isfinite(value):
                return False
        elif kind is list or kind is tuple:
            if not _finite(value):
                return False
        elif kind is dict:
            if not _finite(value.values()):
                return False
        elif kind not in _WHOLE:
            return False
    return True


def _exact(event: Event | FORMS) -> bytes:
    fields = msgspec.to_builtins(event, enc_hook=plain)
    found = list(non_finite(fields))
    return msgspec.json.encode({**fields, "non_finite": found} if found else fields)
