"""Knowledge: the K of MAPE-K, shared by all blocks of one agent (paper, 4.2 and 5.1)."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from ..clock import Clock
from ..errors import InputError, KnowledgeError
from ..event import EventSink
from .graph import KnowledgeGraph
from .query import Answers, Asker, Find, Query, compile_query, read_parameters
from .readable import NoPast, Past
from .robot import RobotModel
from .schema import SCHEMA, Schema
from .signals import SignalTable
from .strategy import StrategyModel
from .world import WorldModel

_KEPT = 256
"""Compiled queries that are kept."""


class _Signals(SignalTable):
    """The table of a Knowledge: frozen, it shows itself in the graph."""

    def __init__(self, graph: KnowledgeGraph) -> None:
        super().__init__()
        self._graph = graph

    def freeze(self) -> None:
        if not self.frozen:
            super().freeze()
            self._graph.bind(self.view)


class Knowledge:
    """All that one robot knows: a graph of what is, and a table of what is measured.

    Args:
        agent: The robot's name, and its node in the graph.
        clock: Where time is read.
        sink: Where changes are emitted.
        schema: What may stand in the graph.
        world: The WorldModel's class, for a user's own (paper, 5.3).
        robot: The RobotModel's class.
        strategy: The StrategyModel's class.

    Attributes:
        agent: The robot's name.
        graph: Nodes and relations.
        signals: Numbers that change every period.
        world: The graph seen as the world.
        robot: The graph and the signals seen as the robot.
        strategy: The graph seen as strategies.
        reactive_models: The ReactiveModels, put there by the agent.
        past: Where queries `as of` a time look; nowhere until somebody who keeps it is put there.

    Raises:
        KnowledgeError: The agent has no name.
    """

    def __init__(
        self,
        agent: str,
        clock: Clock,
        sink: EventSink,
        schema: Schema = SCHEMA,
        world: type[WorldModel] = WorldModel,
        robot: type[RobotModel] = RobotModel,
        strategy: type[StrategyModel] = StrategyModel,
    ) -> None:
        if not agent:
            raise KnowledgeError("a Knowledge needs the name of its agent, found an empty one.")
        self.agent = agent
        self.clock = clock
        self.graph = KnowledgeGraph(clock, sink, agent, schema)
        self.signals: SignalTable = _Signals(self.graph)
        self.graph.add(agent, "robot")
        self.robot = robot(self)
        self.world = world(self)
        self.strategy = strategy(self)
        self.reactive_models: list[Any] = []
        self.past: Past = NoPast()
        self._queries: dict[Any, Query] = {}

    def ask(self, query: str | Find, **parameters: Any) -> Answers:
        """Put a query to the graph, as the robot that it belongs to; see docs/knowledge.md.

        Each text is compiled once. `robot` in it is this robot, where its signal `pose` says that it is.

        Args:
            query: Such as `object where moves and distance(pose, robot) < 2 m`, or `find("object").within("2 m")`.
            parameters: What the text calls by these names: numbers, Quantities, texts, truths, poses, paths.

        Raises:
            InputError: The text is no query; with the column.
            KnowledgeError: A parameter that no query takes, or nobody keeps the past that is asked for.
        """
        return self.query(str(query), **parameters).ask(self.graph, self.asker(), **parameters)

    def holds(self, query: str | Find, **parameters: Any) -> bool:
        """Whether a query has any answer; see `ask`.

        Raises:
            InputError: The text is no query; with the column.
            KnowledgeError: A parameter that no query takes, or nobody keeps the past that is asked for.
        """
        return self.query(str(query), **parameters).holds(self.graph, self.asker(), **parameters)

    def query(self, text: str, **parameters: Any) -> Query:
        """The compiled query of a text, for parameters like these.

        Raises:
            InputError: The text is no query; with the column.
            KnowledgeError: A parameter that no query takes.
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

    def asker(self) -> Asker:
        """The robot as one who asks: its name, where it is, the time, its signals."""
        t = self.clock.now()
        pose = self.robot.pose(t)
        read = self.signals.read
        return Asker(
            self.agent, None if math.isnan(pose.x) else pose, t, lambda name: read(name, t).tolist(), self.past
        )

    @property
    def revision(self) -> int:
        """The graph's revision: how many changes there have been. Signals count their writes themselves."""
        return self.graph.revision
