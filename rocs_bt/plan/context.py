"""The context of a mission: what its leaves and nodes need of the agent."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np
from py_trees.behaviour import Behaviour

from ..action import Action
from ..clock import Clock
from ..errors import Fault, InputError
from ..event import Event, EventSink
from ..expression import TRUTH, Expression, reading
from ..knowledge import Knowledge
from ..pipeline import Pipeline
from ..trees.board import Board
from ..trees.error import TreeError
from ..trees.nodes import Node
from .route import RoutePlanner


@dataclass(frozen=True, eq=False)
class Question:
    """Asks one expression, of one snapshot a tick.

    Attributes:
        expression: The expression, true or false.
        snapshot: Gives the snapshot of the tick under way, and its time [s].
    """

    expression: Expression
    snapshot: Callable[[], tuple[Sequence[float], float]]

    def holds(self) -> bool:
        """Whether it holds now; false where it cannot be told."""
        return bool(self.expression(*self.snapshot()))

    def reading(self) -> str:
        """What it reads now, such as `min(front) = 0.21 m`."""
        return reading(self.expression.node, self.snapshot()[0])


class Content(Protocol):
    """Node classes and route planners of a project, and those that we ship."""

    def load_nodes(self, names: Collection[str] | None = None) -> Sequence[type[Node]]:
        """The node classes of these names that there are, or all."""
        ...

    def load_route(self, name: str) -> type[RoutePlanner]:
        """The route planner of a name.

        Raises:
            InputError: There is none.
        """
        ...


class NoContent:
    """The content of a mission that no catalog loaded: there is none."""

    def load_nodes(self, names: Collection[str] | None = None) -> Sequence[type[Node]]:
        """None at all."""
        return ()

    def load_route(self, name: str) -> type[RoutePlanner]:
        """Refuse.

        Raises:
            InputError: Always.
        """
        hint = "Set `mission.content` to a Catalog, or have the catalog load the mission."
        raise InputError(
            Fault(f"the route planner '{name}' was asked for, and this mission has no catalog.", hint=hint)
        )


@dataclass(frozen=True)
class Survey:
    """Options of a check of a mission: leaves with faults are made all the same, and the faults collected.

    Attributes:
        fit: Whether the robot is the one that the mission is for, and not just any: only then actions must fit it.
        passed: Values of the mission's parameters; a goal or leader among them is reported where the scenario sets the
            parameter, not at the line of the mission.
        later: Nodes that may become known during the run; None where any may.
    """

    fit: bool = True
    passed: Collection[object] = ()
    later: Collection[str] | None = None


class MissionContext:
    """What leaves and nodes of one agent's mission need, however they were made.

    Args:
        name: The mission's name.
        knowledge: All that the robot knows.
        pipeline: Where leaves submit their actions.
        actions: The action table.
        compile_guard: Compiles an expression over the signals; None where there are no expressions.
        rule_reading: Tells a rule's guard with its present readings, for the reason of a robot that is stuck.
        survey: Options of a check of the mission; None in a run.
        rng: Gives a stream of random numbers for a purpose, such as `samples`; in a run the scenario and the seed key
            it, so that a planner that draws repeats.
        privileged: Information for oracle planners only, such as the map of a scene; None for all others.

    Attributes:
        leaves: The leaves that `build` has made, in that order.
        faults: What was found in a survey.
        swap: Puts another subtree in the place of a named one while the mission runs (see `TreePlan.swap`).
        survey: Options of a check; None in a run.
        passed: Parameters of the mission that are texts; only a check gives them.
        board: The board of the tree's root, where `build` may put what its nodes read.
        content: The node classes and route planners that there are by name; the catalog's, where it loaded the mission.
        shared: What nodes of the tree share, by purpose, such as route planners and what they remember.
        privileged: Information for oracle planners only, such as the map of a scene; empty for all others.
    """

    def __init__(
        self,
        name: str,
        *,
        knowledge: Knowledge,
        pipeline: Pipeline,
        actions: Mapping[str, type[Action]],
        compile_guard: Callable[[str], Expression] | None = None,
        rule_reading: Callable[[str], str] = lambda rule: "",
        survey: Survey | None = None,
        rng: Callable[[str], np.random.Generator] = lambda what: np.random.default_rng(0),
        privileged: Mapping[str, Any] | None = None,
    ) -> None:
        self.name = name
        self.knowledge = knowledge
        self.pipeline = pipeline
        self.actions = actions
        self.clock: Clock = pipeline.clock
        self.sink: EventSink = pipeline.sink
        self.rule_reading = rule_reading
        self.rng = rng
        self.leaves: list[Behaviour] = []
        self.faults: list[Fault] = []
        self.swap: Callable[[str, Behaviour], None] = _no_tree
        self.board = Board(name=name)
        self.content: Content = NoContent()
        self.shared: dict[str, Any] = {}
        self.privileged: Mapping[str, Any] = privileged or {}
        self._compile = compile_guard
        self.survey = survey
        self.fit = survey is None or survey.fit
        self.passed: Collection[object] = () if survey is None else survey.passed
        self._later = None if survey is None else survey.later
        self._paths: Mapping[Any, str] = {}
        self._time = self.clock.now()
        self._snapshot: list[float] | None = None

    @property
    def parts(self) -> dict[str, Any]:
        """Keyword arguments for a `Plan` of the mission's agent: `Patrol("patrol", **mission.parts)`."""
        return {name: getattr(self, name) for name in ("knowledge", "pipeline", "actions", "clock", "sink")}

    def ask(self, expression: str) -> Question:
        """An expression over the signals, such as `min(front) > 0.5 m`, to be asked whenever a leaf wants to know.

        Raises:
            InputError: It is no expression, it names no signal, or it is not true or false.
        """
        return Question(self._guard(expression), lambda: (self._seen(), self._time))

    def doubt(self, *faults: Fault) -> None:
        """What a check tells, and a run that goes on all the same does not."""
        if self.survey:
            self.faults.extend(faults)

    def note(self, event: type[Event], **values: Any) -> None:
        """Emit an event of this agent, now."""
        self.sink.emit(event(t=self.clock.now(), agent=self.knowledge.agent, **values))

    def path(self, node: Behaviour) -> str:
        """A node's path from the root, names joined by `/`; its name while it is in no tree."""
        return self._paths.get(node.id, node.name)

    def begin(self, t: float, paths: Mapping[Any, str]) -> None:
        """A tick begins: conditions see one snapshot, taken when the first of them asks."""
        self._time, self._paths, self._snapshot = t, paths, None

    def _guard(self, text: str) -> Expression:
        if self._compile is None:
            raise InputError(f"'{text}' cannot be asked: this mission was given no signals.")
        try:
            guard = self._compile(text)
        except InputError as error:
            raise InputError(*(replace(f, message=f"in '{text}': {f.message}") for f in error.faults)) from error
        if guard.node.kind != TRUTH:
            raise InputError(
                Fault(
                    f"'{text}' is {guard.node.kind.words}, not true or false.",
                    hint=f"Compare it with something, such as '{text} > ...'.",
                )
            )
        return guard

    def _seen(self) -> list[float]:
        """The snapshot of this tick."""
        if self._snapshot is None:
            self._snapshot = self.knowledge.signals.snapshot(self._time).tolist()
        return self._snapshot


def mission_of(node: Node) -> MissionContext:
    """The mission whose tree a node is in.

    Raises:
        TreeError: Its tree works for no mission.
    """
    owner = node.runtime.owner
    if not isinstance(owner, MissionContext):
        raise TreeError(Fault("a node asks for its mission, and its tree was given none."))
    return owner


def _no_tree(name: str, new: Behaviour) -> None:
    """What `swap` is until the mission has a tree."""
    raise InputError(f"'{name}' was to be swapped, but the mission runs no tree yet.")
