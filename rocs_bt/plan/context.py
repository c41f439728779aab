"""Context of a mission: what leaves and nodes can use of their agent."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray
from py_trees.behaviour import Behaviour

from ..base.clock import Clock
from ..base.errors import Fault, InputError
from ..event import Event, EventSink
from ..expression import TRUTH, Expression, reading
from ..interfaces.action import Action
from ..interfaces.pipeline import Pipeline
from ..knowledge import Knowledge
from ..trees.board import Board
from ..trees.error import TreeError
from ..trees.nodes import Node
from .route import RoutePlanner


@dataclass(frozen=True, eq=False)
class SignalCondition:
    """Condition on signals; all conditions of a tick are evaluated on the same snapshot.

    Attributes:
        expression: Compiled expression with a truth value.
        snapshot: Function that returns the snapshot of the current tick and its time [s].
    """

    expression: Expression
    snapshot: Callable[[], tuple[NDArray[np.float64], float]]

    def holds(self) -> bool:
        """Whether the condition is true; false if its value is invalid."""
        return bool(self.expression(*self.snapshot()))

    def reading(self) -> str:
        """Text with the current values in the expression, such as `min(front) = 0.21 m`."""
        return reading(self.expression.node, self.snapshot()[0])


class Content(Protocol):
    """Interface to the node classes, route planners and missions of a project and of this package."""

    def load_nodes(self, names: Collection[str] | None = None) -> Sequence[type[Node]]:
        """Load the available node classes with these names; all classes if `names` is None."""

    def defined_nodes(self, names: Collection[str]) -> Collection[str]:
        """Those of these names of node classes that are available; no class is loaded."""

    def load_route(self, name: str) -> type[RoutePlanner]:
        """Load a route planner class by its name.

        Raises:
            InputError: No route planner has this name.
        """

    def python_tree(self, name: str) -> Callable[..., Any] | None:
        """Load the `build` function of a Python mission that a SubTree names; None if there is no such mission."""

    def tree_files(self) -> Mapping[str, Path]:
        """Files of the missions in XML by name."""

    def root_of(self, file: Path) -> Path:
        """Folder in which the files that a document includes must lie."""


class NoContent:
    """Content without nodes, route planners and missions, for a mission that was not loaded by a catalog."""

    def load_nodes(self, names: Collection[str] | None = None) -> Sequence[type[Node]]:
        """Return no node classes."""
        return ()

    def defined_nodes(self, names: Collection[str]) -> Collection[str]:
        """Return no names."""
        return ()

    def load_route(self, name: str) -> type[RoutePlanner]:
        """Raise an error.

        Raises:
            InputError: Always.
        """
        hint = "Set `mission.content` to a Catalog, or have the catalog load the mission."
        raise InputError(Fault(f"cannot load the route planner '{name}': this mission has no catalog.", hint=hint))

    def python_tree(self, name: str) -> None:
        """Return None."""

    def tree_files(self) -> dict[str, Path]:
        """Return no files."""
        return {}

    def root_of(self, file: Path) -> Path:
        """Return the file's folder."""
        return file.resolve().parent


Position = tuple[Path | None, int, int]
"""File, line and column; None and 0 if unknown."""


@dataclass(frozen=True)
class CheckOptions:
    """Options of a mission check, in which leaves with faults are created and their faults collected.

    Attributes:
        robot: Robot for which the mission is meant, in messages; empty if the robot is an arbitrary one, the limits of
            which do not count.
        passed: File, line and column of each text that is the value of a parameter of the mission. A fault of such a
            value is reported there instead of at the mission's line.
        later: Names of knowledge-graph nodes that may become known during the run; None if any node may.
    """

    robot: str = "this robot"
    passed: Mapping[str, Position] = field(default_factory=dict)
    later: Collection[str] | None = None


class MissionContext:
    """Context of one agent's mission: what its leaves and nodes can use.

    Args:
        name: Name of the mission.
        knowledge: Knowledge of the agent.
        pipeline: Pipeline for the actions of the leaves.
        actions: Actions of the agent, keyed by name.
        compile_guard: Compiler of expressions over the signals; None if there are no signals.
        rule_reading: Function from the name of a reflex rule to the text of its guard values when it last fired, for
            the reason of a failure.
        rule_waits: Function from the name of a reflex rule to whether it waits for something outside of the robot.
        check_options: Options of a check of the mission; None in a run.
        rng: Function from a purpose, such as `samples`, to a random generator. In a run the generators are seeded by
            the scenario and the seed of the run, so that runs are repeatable.
        privileged: Information for oracle planners only, such as the map of a scene; None for all others.
        services: Services of packages by name, such as the connection `ros2`; empty in simulation.
        tables: Tables of packages in robot.toml by name, for checks without a service.
        motion_held: Function that returns the reason for which the safety gate holds the robot in neutral, or an empty
            text.

    Attributes:
        leaves: Leaves created by `build`, in order.
        faults: Faults that a check of the mission has collected.
        swap: Function that replaces a subtree, given by its name, while the mission runs (see `TreePlan.swap`).
        check_options: Options of a check; None in a run, also of a plan that a check has built, once it may run.
        board: Blackboard of the root, where `build` may store values for nodes.
        content: Access to nodes, route planners and missions; empty unless a catalog loaded the mission.
        dialect: Dialect of the XML trees that the mission loads: that of the scenario, or Nav2's if the mission's own
            file is recognised as such; empty to recognise it.
        shared: Objects that nodes of the tree share, by purpose, such as route planners with their state.
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
        rule_waits: Callable[[str], bool] = lambda rule: False,
        check_options: CheckOptions | None = None,
        rng: Callable[[str], np.random.Generator] = lambda what: np.random.default_rng(0),
        privileged: Mapping[str, Any] | None = None,
        services: Mapping[str, Any] = MappingProxyType({}),
        tables: Mapping[str, Any] = MappingProxyType({}),
        motion_held: Callable[[], str] = lambda: "",
    ) -> None:
        self.name = name
        self.knowledge = knowledge
        self.pipeline = pipeline
        self.actions = actions
        self.clock: Clock = pipeline.clock
        self.sink: EventSink = pipeline.sink
        self.rule_reading = rule_reading
        self.rule_waits = rule_waits
        self.rng = rng
        self.leaves: list[Behaviour] = []
        self.faults: list[Fault] = []
        self.swap: Callable[[str, Behaviour], None] = _no_tree
        self.board = Board(name=name)
        self.content: Content = NoContent()
        self.dialect = ""
        self.shared: dict[str, Any] = {}
        self.privileged: Mapping[str, Any] = privileged or {}
        self.services, self.tables = services, tables
        self.motion_held = motion_held
        self._compile = compile_guard
        self.check_options = check_options
        self._paths: Mapping[Any, str] = {}
        self._time = self.clock.now()
        self._snapshot: NDArray[np.float64] | None = None

    @property
    def parts(self) -> dict[str, Any]:
        """Keyword arguments for the constructor of a `Plan`, as in `Patrol("patrol", **mission.parts)`."""
        return {name: getattr(self, name) for name in ("knowledge", "pipeline", "actions", "clock", "sink")}

    @property
    def fit(self) -> bool:
        """Whether the robot is the one for which the mission is meant."""
        return self.check_options is None or bool(self.check_options.robot)

    @property
    def passed(self) -> Mapping[str, Position]:
        """Position of each value of a parameter that is a text; empty except in a check."""
        return {} if self.check_options is None else self.check_options.passed

    def signal_condition(self, expression: str) -> SignalCondition:
        """Compile a condition on signals, such as `min(front) > 0.5 m`.

        Raises:
            InputError: The text is not an expression, names an unknown signal, or is not true or false.
        """
        return SignalCondition(self._guard(expression), lambda: (self._snapshot_of_tick(), self._time))

    def report(self, *faults: Fault) -> None:
        """Record faults if the mission is being checked; does nothing in a run."""
        if self.check_options:
            self.faults.extend(faults)

    def note(self, event: type[Event], **values: Any) -> None:
        """Emit an event of this agent with the current time.

        Args:
            event: Class of the event.
            values: Its fields, except `t` and `agent`.
        """
        self.sink.emit(event(t=self.clock.now(), agent=self.knowledge.agent, **values))

    def path(self, node: Behaviour) -> str:
        """Path of a node: names from the root to the node, joined by `/`; just its name outside of a tree."""
        return self._paths.get(node.id, node.name)

    def begin(self, t: float, paths: Mapping[Any, str]) -> None:
        """Begin a tick. Its conditions share one snapshot, which is taken when the first of them is evaluated.

        Args:
            t: Time of the tick [s].
            paths: Path of each node, keyed by its `id`.
        """
        self._time, self._paths, self._snapshot = t, paths, None

    def _guard(self, text: str) -> Expression:
        if self._compile is None:
            raise InputError(f"cannot evaluate '{text}': this mission has no signals.")
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

    def _snapshot_of_tick(self) -> NDArray[np.float64]:
        """Values of the snapshot of this tick."""
        if self._snapshot is None:
            self._snapshot = self.knowledge.signals.snapshot(self._time)
        return self._snapshot


def mission_of(node: Node) -> MissionContext:
    """Context of the mission that contains a node in its tree.

    Raises:
        TreeError: The tree does not belong to a mission.
    """
    owner = node.runtime.owner
    if not isinstance(owner, MissionContext):
        raise TreeError(Fault("a node needs its mission, but its tree has none."))
    return owner


def _no_tree(name: str, new: Behaviour) -> None:
    """Raise an error; this is the value of `swap` until the mission has a tree."""
    raise InputError(f"cannot swap '{name}': the mission has no running tree yet.")
