"""Events of Monitor, Analyze and Knowledge: readings, signals, changes, facts, and peers."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import ClassVar

from ..base.errors import RecordingError
from .sink import Event, Level, Value, unpack


class SensorRead(Event, frozen=True, kw_only=True):
    """A sensor was read. `stamp` is the device's sampling time [s]; `data` the packed values in SI units."""

    sensor: str
    stamp: float
    data: bytes

    @property
    def values(self) -> list[float]:
        """Values of the reading, SI units."""
        return unpack(self.data)


class SensorFailed(Event, frozen=True, kw_only=True):
    """A sensor could not be read; its signals become stale."""

    sensor: str
    detail: str
    level: ClassVar[Level] = Level.ERROR

    @property
    def sentence(self) -> str:
        return f"sensor {self.sensor} failed: {self.detail}"


class SignalsWritten(Event, frozen=True, kw_only=True, omit_defaults=True):
    """A monitor or an analyser wrote signals to Knowledge: names, sizes, and the concatenated packed values.

    `stamp` is the time to which the values refer [s]; None if it equals `t`.
    """

    monitor: str
    signals: tuple[str, ...]
    sizes: tuple[int, ...]
    data: bytes
    stamp: float | None = None

    def parts(self) -> Iterator[tuple[str, memoryview]]:
        """Name and packed values of each signal.

        Raises:
            RecordingError: The sizes, of a damaged recording, do not fit the values.
        """
        data, at = memoryview(self.data), 0
        if len(self.sizes) != len(self.signals) or 8 * sum(self.sizes) != len(data) or min(self.sizes, default=0) < 0:
            raise RecordingError(
                f"the recording is damaged: '{self.monitor}' wrote {len(data) // 8} values at t = {self.t:g} s."
            )
        for name, size in zip(self.signals, self.sizes, strict=True):
            yield name, data[at : at + 8 * size]
            at += 8 * size

    @property
    def values(self) -> dict[str, list[float]]:
        """Values of each signal, SI units, by name of the signal.

        Raises:
            RecordingError: The sizes, of a damaged recording, do not fit the values.
        """
        return {name: unpack(part) for name, part in self.parts()}


class Change(Event, frozen=True, kw_only=True):
    """An analyser detected a change of the world; the event is also passed to Plan (paper, 4.2).

    Attributes:
        source: Name of the analyser.
        kind: Kind of the change, such as `obstacle` or `arrived`.
        subject: Node of the knowledge graph that changed; may be empty.
        values: Values that describe the change, in SI units.
    """

    source: str
    kind: str
    subject: str = ""
    values: Mapping[str, Value] = {}


class MapChanged(Event, frozen=True, kw_only=True):
    """Cells of the robot's own map became occupied, or ceased to be, since the last such event.

    Attributes:
        cell: Side of a cell [m].
        occupied: New occupied cells, as numbers along x and y: the cell (0, 0) begins at the world's origin.
        cleared: Cells that are no longer occupied, or have left the map.
    """

    cell: float
    occupied: tuple[tuple[int, int], ...] = ()
    cleared: tuple[tuple[int, int], ...] = ()


class KnowledgeChanged(Event, frozen=True, kw_only=True):
    """The knowledge graph changed.

    Attributes:
        what: Kind of the change: `node added`, `node removed`, `attribute`, `edge added`, `edge changed`, `edge
            removed`.
        subject: Node, or source of the edge.
        name: Attribute, relation of the edge, or kind of the node.
        value: New value; for an edge, its target.
        revision: Revision of Knowledge after the change.
        attributes: Attributes of an added or changed edge.
    """

    what: str
    subject: str
    name: str
    value: Value = None
    revision: int = 0
    attributes: Mapping[str, Value] = {}


class SubscriberDetached(Event, frozen=True, kw_only=True):
    """A subscriber of knowledge changes raised an exception and was detached; `revision` is that of the change."""

    callback: str
    revision: int
    detail: str
    level: ClassVar[Level] = Level.ERROR

    @property
    def sentence(self) -> str:
        return f"{self.callback} raised: {self.detail}"


class PeerAppeared(Event, frozen=True, kw_only=True):
    """An agent that shares its knowledge appeared or reappeared; `start` identifies its process start."""

    peer: str
    start: str


class PeerVanished(Event, frozen=True, kw_only=True):
    """An agent that shares its knowledge left or is no longer received; `start` identifies its process start."""

    peer: str
    start: str


class PeerFault(Event, frozen=True, kw_only=True):
    """A fault occurred in the exchange of knowledge with a peer; emitted once per kind and start of the peer.

    `kind` is `refused` (a write of the peer was refused), `behind` (the peer's clock was behind, and was corrected) or
    `clock` (this agent's own clock was behind the peer's, and was corrected).
    """

    peer: str
    start: str
    kind: str
    detail: str
    level: ClassVar[Level] = Level.WARNING

    @property
    def sentence(self) -> str:
        return f"peer {self.peer}: {self.detail}"
