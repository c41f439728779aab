"""Importer: builds a state from nodes and edges of another program; checks them against the schema."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import msgspec

from ...base.clock import SimulatedClock
from ...base.errors import Fault, InputError, KnowledgeError
from ...event import NullSink, Value
from ..declaration import checked
from ..graph import KnowledgeGraph
from ..readable import Stamp
from ..schema import Schema
from .state import State
from .values import plain, typed

Revision = Annotated[int, msgspec.Meta(ge=0, le=2**62)]
Time = Annotated[float, msgspec.Meta(ge=-1e15, le=1e15)]


class NodeEntry(msgspec.Struct, forbid_unknown_fields=True):
    """Node in an import file; `stamps` has time [s] and revision of each attribute, by default those of the node."""

    name: Annotated[str, msgspec.Meta(min_length=1)]
    kind: str
    t: Time
    revision: Revision
    attributes: dict[str, Any] = {}
    stamps: dict[str, tuple[Time, Revision]] = {}


class EdgeEntry(msgspec.Struct, forbid_unknown_fields=True):
    """Edge in an import file."""

    source: str
    relation: str
    target: str
    t: Time
    revision: Revision
    attributes: dict[str, Any] = {}


class Importer:
    """Builds a state from imported entries."""

    def __init__(self, file: Path, agent: str, schema: Schema) -> None:
        self.faults: list[Fault] = []
        self.state = State(agent, schema)
        self._file = file
        self._schema = schema
        # A live graph that receives the same entries, because it has all the checks.
        self._graph = KnowledgeGraph(SimulatedClock(1.0), NullSink(), agent, schema)

    def node(self, entry: NodeEntry) -> None:
        """Add a node, or record the fault."""
        try:
            values = self._values((entry.kind, entry.name), self._schema.kind(entry.kind).attributes, entry.attributes)
            self._graph.add(entry.name, entry.kind, **values)
            if unknown := entry.stamps.keys() - values.keys():
                raise KnowledgeError(f"'{entry.name}' has a stamp of '{min(unknown)}', but no such attribute.")
        except KnowledgeError as error:
            self.fault(str(error))
            return
        stamp = Stamp(entry.t, entry.revision)
        self.state.add(entry.name, entry.kind, stamp)
        for name, value in values.items():
            self.state.write(entry.name, name, plain(value), Stamp(*entry.stamps.get(name, stamp)))

    def edge(self, entry: EdgeEntry) -> None:
        """Add an edge, or record the fault."""
        source, relation, target = entry.source, entry.relation, entry.target
        try:
            declared = self._schema.relation(relation)
            values = self._values((source, relation, target), declared.attributes, entry.attributes)
            if there := self._graph.related(source, relation):
                if target in there:
                    raise KnowledgeError(f"the edge {source} -{relation}-> {target} is there twice.")
                if declared.single:
                    raise KnowledgeError(f"'{source}' {relation} '{there[0]}' already, and may have one only.")
            # An attribute that the file omits was unknown, even if it has a default.
            unknown = dict.fromkeys(name for name, each in declared.attributes.items() if not each.required)
            self._graph.relate(source, relation, target, **(unknown | values))
        except KnowledgeError as error:
            self.fault(str(error))
            return
        known = {name: plain(value) for name, value in (self._graph.edge(source, relation, target) or {}).items()}
        self.state.relate(source, relation, target, known, Stamp(entry.t, entry.revision))

    def fault(self, message: str) -> None:
        """Record a fault."""
        self.faults.append(Fault(message, self._file))

    def done(self, t: float, revision: int) -> State:
        """Set the time [s] and the revision of the state, and return it.

        Raises:
            InputError: All faults.
        """
        if self.faults:
            raise InputError(*self.faults)
        self.state.t, self.state.revision = t, revision
        return self.state

    @staticmethod
    def _values(owner: tuple[str, ...], declared: Mapping[str, Any], given: Mapping[str, Value]) -> dict[str, Any]:
        return checked(owner, declared, {name: typed(value, declared.get(name)) for name, value in given.items()})
