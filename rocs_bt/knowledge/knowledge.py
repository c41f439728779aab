"""Knowledge: the K of MAPE-K, shared by all blocks of one agent (paper, 4.2 and 5.1)."""

from __future__ import annotations

from typing import Any

from ..clock import Clock
from ..errors import KnowledgeError
from ..event import EventSink
from .declaration import Schema
from .graph import KnowledgeGraph
from .robot import RobotModel
from .schema import SCHEMA
from .signals import SignalTable
from .strategy import StrategyModel
from .world import WorldModel


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

    @property
    def revision(self) -> int:
        """The graph's revision: how many changes there have been. Signals count their writes themselves."""
        return self.graph.revision
