"""PythonPlanner: interface of planners that are no behaviour trees, with the methods `reset` and `act`."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from ..base.errors import Fault, InputError
from ..base.geometry import Pose2, Twist2, Twist3
from ..base.raised import Raised, from_actuator
from ..control.locomotion import Locomotion
from ..declare import class_fields, constructed, refuse_constructor
from ..interfaces.pipeline import Ticket
from ..knowledge import Knowledge
from .mission import Mission
from .plan import SUCCESS, Plan
from .route import RoutePlanner

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Task:
    """Task of a planner, which it is given at the beginning of an episode.

    Attributes:
        goals: Goal poses by name of the goal, world frame; yaw is 0 if irrelevant.
        tolerances: Goal tolerances by name of the goal [m].
        locomotion: Locomotion of the robot, with its limits.
        knowledge: Knowledge of the robot: knowledge graph, model of itself, signals.
        route: Function from the name of a file in planners/routes to a route planner of its class.
        privileged: Information for oracle planners only; empty for all others.
    """

    goals: Mapping[str, Pose2]
    tolerances: Mapping[str, float]
    locomotion: Locomotion
    knowledge: Knowledge
    route: Callable[[str], RoutePlanner]
    privileged: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Observation:
    """Observation of the robot and its signals at one time.

    Attributes:
        t: Time since the beginning of the episode [s].
        pose: Estimated pose of the robot, world frame; NaN if unknown.
        signals: All signals of the robot by name, SI units, each an array of its values; NaN if a value is stale or
            broken.
    """

    t: float
    pose: Pose2
    signals: Mapping[str, Array]


class PythonPlanner(Protocol):
    """Interface of a planner that is no behaviour tree.

    Its annotations are its parameters, and its constructor takes them by keyword.

        @dataclass(kw_only=True)
        class Straight:
            speed: PositiveMetresPerSecond = 0.3

            def reset(self, task, rng):
                (self.goal,) = task.goals.values()

            def act(self, observation):
                if observation.pose.distance(self.goal) < 0.1:
                    return None
                return Twist2(forward=self.speed)
    """

    def reset(self, task: Task, rng: np.random.Generator) -> None:
        """Begin an episode.

        Args:
            task: Task of the episode.
            rng: Random generator, seeded by the scenario and the seed of the run.
        """

    def act(self, observation: Observation) -> Sequence[float] | Twist2 | Twist3 | None:
        """Decide on the motion. It is called once per period of the plan, and must not block.

        Args:
            observation: Present observation.

        Returns:
            Body twist, which suits any robot, or the values of the motion command (`locomotion.values`; on wheels
            their linear speeds [m/s]). It is held until the next call. None if the planner considers the task done; it
            is then not called again.
        """


class PythonPlan(Plan):
    """Plan that runs a PythonPlanner.

    Each decision becomes an action with NORMAL priority: SetWheelSpeed, or SetTwist on bodies without wheels. Reflexes
    pre-empt these actions as they pre-empt those of a tree. While a reflex is active, the planner is not called.

    Args:
        planner: Planner to run.
        mission: Mission of the agent.
    """

    def __init__(self, planner: PythonPlanner, mission: Mission) -> None:
        super().__init__(mission.name, **mission.parts)
        self._planner = planner
        self._mission = mission
        self._ticket: Ticket | None = None
        self._begun = False

    def run(self, t: float) -> None:
        self.changes()
        if self.status == SUCCESS or self.pipeline.held:
            return
        if not self._begun:
            self._planner.reset(self._task(), self._mission.rng(self.name))
            self._begun = True
        decided = self._planner.act(self._observe(t))
        if self._ticket is not None:
            self.pipeline.cancel(self._ticket, by=self.name)
            self._ticket = None
        if decided is None:
            self.status = SUCCESS
        else:
            self._ticket = self._move(decided)

    def blame(self, error: BaseException) -> Raised | None:
        if from_actuator(error):
            return None
        step = self._planner.act if self._begun else self._planner.reset
        return super().blame(error) or Raised.of("planner", type(self._planner).__name__, error, step)

    def content_of(self, owner: object) -> tuple[str, str] | None:
        if owner is self._planner:
            return "planner", type(self._planner).__name__
        return super().content_of(owner)

    def _move(self, decided: Any) -> Ticket:
        """Submit a planner's decision as an action; raises InputError."""
        locomotion = self.knowledge.robot.locomotion
        try:
            moves = isinstance(decided, (Twist2, Twist3))
            values = locomotion.command(decided) if moves else np.array(decided, dtype=float)
        except (TypeError, ValueError):
            values = np.zeros(0)
        if values.shape != (len(locomotion.values),) or not np.isfinite(values).all():
            message = (
                f"act of {type(self._planner).__name__} returned {decided!r:.200}, which the robot cannot execute."
            )
            what = "wheel linear speeds in m/s" if locomotion.wheels else "components of a twist in m/s and rad/s"
            names = ", ".join(locomotion.values)
            hint = f"Return {len(locomotion.values)} {what} ({names}), a Twist2, or None at the end."
            raise InputError(Fault(message, hint=hint))
        if locomotion.wheels:
            return self.submit("SetWheelSpeed", speeds=values.tolist())
        return self.submit("SetTwist", **locomotion.twist3(values)._asdict())

    def _task(self) -> Task:
        world, graph = self.knowledge.world, self.knowledge.graph
        goals = {name: pose for name in world.goals() if (pose := world.pose_of(name)) is not None}
        return Task(
            goals=goals,
            tolerances={name: float(graph.get(name, "tolerance")) for name in goals},
            locomotion=self.knowledge.robot.locomotion,
            knowledge=self.knowledge,
            privileged=self._mission.privileged,
            route=lambda name: self._mission.content.load_route(name)(self.knowledge),
        )

    def _observe(self, t: float) -> Observation:
        table = self.knowledge.signals
        row = table.snapshot(t)
        signals = {name: row[table.slice_of(name)] for name in table.names}
        return Observation(t, self.knowledge.robot.pose(t), signals)


def python_mission(cls: type[Any]) -> Callable[..., PythonPlan]:
    """Create the `build` function of a mission that runs a planner class; its parameters are those of the class.

    Raises:
        InputError: The class has no `reset` or no `act`, or a constructor with parameters.
    """
    refuse_constructor(cls)
    for method in ("reset", "act"):
        if not callable(getattr(cls, method, None)):
            hint = "A planner has reset(task, rng) and act(observation)."
            raise InputError(Fault(f"the class '{cls.__name__}' has no '{method}'.", hint=hint))

    def build(mission: Mission, **parameters: Any) -> PythonPlan:
        return PythonPlan(constructed(cls, parameters), mission)

    vars(build)["parameters"] = class_fields(cls)
    build.__module__, build.__doc__ = cls.__module__, cls.__doc__
    return build
