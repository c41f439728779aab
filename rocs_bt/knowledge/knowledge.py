"""Knowledge: the K of MAPE-K, shared by all blocks of one agent (paper, 4.2 and 5.1)."""

from __future__ import annotations

from typing import Any

from ..base.clock import Clock
from ..base.geometry import Pose2
from ..event import EventSink
from .base import KnowledgeBase
from .robot import RobotModel
from .schema import SCHEMA, Schema
from .strategy import StrategyModel
from .world import WorldModel


class Knowledge(KnowledgeBase):
    """Knowledge of one robot: graph, signals, and three models as views of them.

    Args:
        agent: Name of the robot and of its node in the graph.
        clock: Source of time.
        sink: Receives changes of the graph.
        schema: Kinds of nodes and relations that the graph may hold.
        world: Class of the WorldModel; a user may extend it (paper, 5.3).
        robot: Class of the RobotModel.
        strategy: Class of the StrategyModel.

    Attributes:
        world: View of the graph as the world.
        robot: View of the graph and the signals as the robot.
        strategy: View of the graph as strategies.
        reactive_models: ReactiveModel objects of the agent's rules; the agent adds them.

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
        super().__init__(agent, clock, sink, schema)
        self.robot = robot(self)
        self.world = world(self)
        self.strategy = strategy(self)
        self.reactive_models: list[Any] = []

    def pose(self, t: float | None = None) -> Pose2:
        return self.robot.pose(t)
