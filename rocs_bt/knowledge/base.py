"""Knowledge base: graph and signals of one agent, queries over them, and the base of views (paper, 4.2 and 5.1)."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from pathlib import Path
from typing import Any

from ..base.clock import Clock
from ..base.errors import InputError, KnowledgeError
from ..base.geometry import Pose2
from ..event import Event, EventSink
from .graph import KnowledgeGraph
from .history import ChangeLog, GraphState
from .query import Answers, Find, Query, QueryContext, compile_query, read_parameters
from .schema import Schema
from .signals import SignalTable

_KEPT = 256
"""Maximum number of cached compiled queries."""
_CHANGES = 100_000
"""Maximum number of changes of the graph that are kept for `as of` queries."""


class _Signals(SignalTable):
    """Signal table of a knowledge base; `freeze` makes its live views available in the graph."""

    def __init__(self, graph: KnowledgeGraph) -> None:
        super().__init__()
        self._graph = graph

    def freeze(self) -> None:
        if not self.frozen:
            super().freeze()
            self._graph.bind(self.view)


class _Logged:
    """Sink of the graph that also logs its changes; not a Fanout, because a run's sink replaces its `emit` later."""

    def __init__(self, sink: EventSink, log: ChangeLog) -> None:
        self._sink, self._log = sink, log

    def emit(self, event: Event) -> None:
        self._sink.emit(event)
        self._log.emit(event)


class KnowledgeBase(ABC):
    """Graph of facts and table of measured signals of one agent; the abstract base of Knowledge.

    Args:
        agent: Name of the robot and of its node in the graph.
        clock: Source of time.
        sink: Receives changes of the graph.
        schema: Kinds of nodes and relations that the graph may hold.

    Attributes:
        agent: Name of the robot.
        graph: Nodes and relations.
        signals: Measured values, which change in every control period.
        past: Log of the graph's changes, for `as of` queries.

    Raises:
        KnowledgeError: The agent has no name.
    """

    def __init__(self, agent: str, clock: Clock, sink: EventSink, schema: Schema) -> None:
        if not agent:
            raise KnowledgeError("a Knowledge needs the name of its agent, found an empty one.")
        self.agent = agent
        self.clock = clock
        self.sink = sink
        self.past = ChangeLog(GraphState(agent, schema), keep=_CHANGES)
        self.graph = KnowledgeGraph(clock, _Logged(sink, self.past), agent, schema)
        self.signals: SignalTable = _Signals(self.graph)
        self.graph.add(agent, "robot")
        self._queries: dict[Any, Query] = {}

    @abstractmethod
    def pose(self, t: float | None = None) -> Pose2:
        """Pose of the robot in the world frame [m, m, rad] at a time [s], now by default; all NaN while unknown."""

    def ask(self, query: str | Find, **parameters: Any) -> Answers:
        """Run a query on the graph, as seen by this robot; see docs/knowledge.md.

        Each text is compiled once. `robot` in a query is this robot, at the pose of its signal `pose`.

        Args:
            query: Query such as `object where moves and distance(pose, robot) < 2 m`, or
                `find("object").within("2 m")`.
            parameters: Values of the query's parameters, by name: numbers, Quantities, texts, booleans, poses, paths.

        Raises:
            InputError: The text is not a query; with the column.
            KnowledgeError: A parameter has an unsupported type, or the state for an `as of` query is not kept.
        """
        return self.query(str(query), **parameters).ask(self.graph, self.query_context(), **parameters)

    def holds(self, query: str | Find, **parameters: Any) -> bool:
        """Whether a query has any answer; see `ask`.

        Raises:
            InputError: The text is not a query; with the column.
            KnowledgeError: A parameter has an unsupported type, or the state for an `as of` query is not kept.
        """
        return self.query(str(query), **parameters).holds(self.graph, self.query_context(), **parameters)

    def query(self, text: str, **parameters: Any) -> Query:
        """Compile a query text for parameters of the given values' types; compiled queries are cached.

        Raises:
            InputError: The text is not a query; with the column.
            KnowledgeError: A parameter has an unsupported type.
        """
        types = read_parameters(parameters)[0] if parameters else {}
        key = (text, *types.items(), self.signals.frozen)
        if key not in self._queries:
            if len(self._queries) >= _KEPT:
                self._queries.clear()
            signals = self.signals if self.signals.frozen else None
            try:
                self._queries[key] = compile_query(text, self.graph.schema, signals, types)
            except InputError as error:
                raise error.at(Path("query"), 1) from error
        return self._queries[key]

    def query_context(self) -> QueryContext:
        """Data that queries read besides the graph: name and pose of the robot, time, signals, and past states."""
        t = self.clock.now()
        pose, read = self.pose(t), self.signals.read
        return QueryContext(
            self.agent, None if math.isnan(pose.x) else pose, t, lambda name: read(name, t).tolist(), self.past
        )

    @property
    def revision(self) -> int:
        """Number of graph changes so far; each signal counts its own writes."""
        return self.graph.revision


class Model:
    """View of Knowledge; a user's subclass adds properties (paper, 5.3)."""

    def __init__(self, knowledge: KnowledgeBase) -> None:
        self.knowledge = knowledge
        self.graph = knowledge.graph
        self.signals = knowledge.signals
        self.name = knowledge.agent
