"""The function `play`: tick a mission from start to end without a robot."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...base.errors import Fault, InputError, unknown
from ...catalog import TREES, Catalog
from ...event import Said
from ...knowledge import Knowledge
from ...plan import Act, Mission, mission_actions, mission_arguments, mission_nodes, shipped_nodes, xml_mission
from ...trees.board import Board
from ...trees.nodes import RUNNING, Decorator, Leaf, Node, Tree
from ...trees.status import FAILURE, IDLE, Outcome, outcome_name
from .coverage import TreeCoverage, outline
from .environment import Known, MissionEnvironment, checked_ticks
from .inject import inject
from .match import wild
from .scripted import ScriptedOutcomes
from .substitute import Rule, substitute

if TYPE_CHECKING:
    from ...trees import Behaviour


LETTERS = {"RUNNING": "R", "SUCCESS": "S", "FAILURE": "F", "SKIPPED": "K", "IDLE": "H"}


@dataclass(frozen=True, kw_only=True)
class PlayOptions:
    """Test conditions of a mission, for `play`.

    Attributes:
        leaves: Outcomes of leaves, one letter per tick (see `ScriptedOutcomes`), keyed by filter of leaves (see
            `substitute`). An XML leaf that has no class becomes a stub if a filter here names it.
        rules: Other replacements, keyed by filter of nodes; see `substitute`.
        faults: Functions that create a fault decorator, keyed by filter of nodes; see `inject`.
        knowledge: Initial knowledge.
        signals: Values of the signals, such as `{"front": "0.4 m"}`.
        parameters: Parameters of the mission, as in a scenario file.
        board: Initial values of the root's blackboard, by name.
        then: Functions to run before a tick, keyed by the number of the tick, counted from 1.
        ticks: Maximum number of ticks.
        step: Simulated time between two ticks [s]; the clock does not advance otherwise.
        settle: Whether to repeat each tick, without advancing the clock, until only time can change the result.
        main: ID of the tree to play, for an XML document with several trees; the document's main tree if empty.
        catalog: Source of content; the project around the current folder and the shipped content by default.
        coverage: Counter of node outcomes.
    """

    leaves: Mapping[str, str | ScriptedOutcomes] = field(default_factory=dict)
    rules: Mapping[str, Rule] = field(default_factory=dict)
    faults: Mapping[str, Callable[[Behaviour], Decorator]] = field(default_factory=dict)
    knowledge: Known = field(default_factory=dict)
    signals: Mapping[str, Any] = field(default_factory=dict)
    parameters: Mapping[str, Any] = field(default_factory=dict)
    board: Mapping[str, Any] = field(default_factory=dict)
    then: Mapping[int, Callable[[Mission], None]] = field(default_factory=dict)
    ticks: int = 100
    step: float = 0.1
    settle: bool = False
    main: str = ""
    catalog: Catalog | None = None
    coverage: TreeCoverage | None = None


def play(mission: str | Path | Callable[..., Any], options: PlayOptions = PlayOptions(), **changes: Any) -> Trace:
    """Tick a mission until it ends, without a robot.

        trace = play("patrol", leaves={"GoTo": "RRS", "Speak": "S"}, knowledge={"dock": (1.0, 2.0)})
        assert trace.outcome == "SUCCESS"
        assert trace["GoTo dock"] == "R R S"

    Args:
        mission: Name or path of a mission, text of an XML document, or `build` function of a Python mission.
        options: Test conditions.
        changes: Attributes of `PlayOptions` as keywords, which override `options`.

    Returns:
        Outcomes of all nodes, tick by tick.

    Raises:
        InputError: The mission is invalid, a filter matches no node, or a leaf needs a robot; or TreeError, if a node
            cannot continue.
    """
    given = replace(options, **changes)
    catalog, scripted = given.catalog or Catalog.here(), _scripted(given.leaves)
    build, name = _build(mission, catalog, scripted, given.main)
    actions = mission_actions(build)
    environment = MissionEnvironment(
        given.knowledge, given.signals, step=given.step, actions=actions, content=catalog, name=name
    )
    own = environment.mission
    root = build(own, **mission_arguments(build, given.parameters))
    if scripted or given.rules:
        every = mission_nodes(own.actions, catalog.load_nodes())
        root = substitute(root, {**scripted, **given.rules}, every)
    if given.faults:
        root = inject(root, given.faults)
    _refuse_robots(root)
    tree = Tree(root, board=own.board, clock=environment.clock, owner=own)
    own.board.update(given.board)
    return _Player(tree, environment, given.coverage).play(checked_ticks(given.ticks), given.then, given.settle)


class _Player:
    def __init__(self, tree: Tree, environment: MissionEnvironment, coverage: TreeCoverage | None) -> None:
        self.tree, self.environment = tree, environment
        self.paths = {node.id: path for node, path, _ in outline(tree.root)}
        self.cells: dict[str, list[str]] = {path: [] for path in self.paths.values()}
        self.outcomes: list[str] = []
        self.times: list[float] = []
        tree.watch(self._hear)
        self.stock = {node: IDLE for node in tree.nodes if not isinstance(node, Node)}
        self.update_coverage = coverage.watch(environment.mission.name, tree) if coverage is not None else lambda: None

    def play(self, ticks: int, then: Mapping[int, Callable[[Mission], None]], settle: bool) -> Trace:
        mission, clock = self.environment.mission, self.environment.clock
        for tick in range(1, ticks + 1):
            if tick in then:
                then[tick](mission)
            for row in self.cells.values():
                row.append("")
            mission.begin(clock.now(), self.paths)
            outcome = self.tree.settle() if settle else self.tree.tick()
            self._record_stock_nodes(outcome)
            self.update_coverage()
            self.outcomes.append(outcome_name(outcome))
            self.times.append(clock.now())
            clock.advance()
            if outcome is not RUNNING:
                break
        return Trace(
            tuple(self.outcomes),
            {path: tuple(cell or "." for cell in row) for path, row in self.cells.items()},
            self.tree.board,
            self.environment.knowledge,
            tuple(e.text for e in self.environment.sink.events if isinstance(e, Said)),
            self._reason(outcome),
            tuple(self.times),
        )

    def _hear(self, node: Behaviour, outcome: Outcome) -> None:
        if node.id in self.paths:
            self.cells[self.paths[node.id]][-1] += LETTERS[outcome_name(outcome)]

    def _record_stock_nodes(self, outcome: Outcome) -> None:
        """Record the status of changed and running stock py_trees nodes, which do not report it themselves."""
        for node, before in self.stock.items():
            if node.status is RUNNING or node.status is not before or node is self.tree.root:
                self._hear(node, outcome if node is self.tree.root else node.status)
                self.stock[node] = node.status

    def _reason(self, outcome: Outcome) -> str:
        if outcome is not FAILURE:
            return ""
        tip = self.tree.root.tip() or self.tree.root
        return str(tip.feedback_message)


def _scripted(leaves: Mapping[str, str | ScriptedOutcomes]) -> dict[str, Rule]:
    return {text: ScriptedOutcomes(given) if isinstance(given, str) else given for text, given in leaves.items()}


def _build(
    mission: str | Path | Callable[..., Any], catalog: Catalog, scripted: Iterable[str], main: str
) -> tuple[Callable[..., Any], str]:
    """Return a function that builds the mission's tree, and the mission's name."""
    if callable(mission):
        return mission, getattr(mission, "__name__", "mission")

    def nodes(tags: set[str]) -> list[Any]:
        return _nodes(catalog, tags, scripted)

    def others(name: str) -> Callable[..., Any] | None:
        there = any(e.name == name and e.path.suffix == ".py" for e in catalog.list("mission"))
        return catalog.load_mission(name) if there else None

    if isinstance(mission, str) and mission.lstrip().startswith("<"):
        return xml_mission(mission, main=main, nodes=nodes, missions=others), main or "mission"
    entry = catalog.find("mission", str(mission))
    if entry.path.suffix not in TREES:
        return catalog.load_mission(str(entry.path)), entry.name
    root = catalog.root_of(entry.path)
    return xml_mission(entry.path, main=main, within=root, nodes=nodes, missions=others), entry.name


def _nodes(catalog: Catalog, tags: Iterable[str], scripted: Iterable[str]) -> list[Any]:
    """Node classes of the project for some tags, and stubs for tags without a class that have scripted outcomes."""
    from ...actions import ACTIONS

    unknown = set(tags) - {*shipped_nodes(), *ACTIONS}
    found = catalog.load_nodes(unknown)
    missing = unknown - {node.tag for node in found}
    return [*found, *(stub_leaf(tag) for tag in sorted(missing) if tag in set(scripted) and not wild(tag))]


def _refuse_robots(root: Behaviour) -> None:
    """Refuse leaves that submit actions, since no robot executes them."""
    names = sorted({node.name for node, _, _ in outline(root) if isinstance(node, Act)})
    if names:
        hint = f'Script them: leaves={{"{names[0]}": "RRS"}}, or all of them: leaves={{"*": "S"}}.'
        raise InputError(Fault(f"these leaves need a robot: {', '.join(names)}.", hint=hint))


@dataclass(frozen=True)
class Trace:
    """Record of a mission.

        trace["GoTo dock"] == "R R S"    # `.` if not ticked, `H` if halted, `RH` for both

    Attributes:
        outcomes: Name of the root's outcome in each tick, such as `RUNNING`.
        cells: Outcomes of each node as letters, one text per tick; keyed by the node's path.
        board: Blackboard of the root.
        knowledge: Knowledge at the end.
        said: Texts that the mission spoke or logged, in order of time.
        reason: Feedback message of the node that decided the last outcome; may be empty.
        times: Time of each tick [s].
    """

    outcomes: tuple[str, ...]
    cells: Mapping[str, tuple[str, ...]]
    board: Board
    knowledge: Knowledge
    said: tuple[str, ...]
    reason: str
    times: tuple[float, ...]

    @property
    def outcome(self) -> str:
        """Last outcome of the root."""
        return self.outcomes[-1]

    @property
    def ticks(self) -> int:
        """Number of ticks."""
        return len(self.outcomes)

    def __getitem__(self, node: str) -> str:
        """Return the outcomes of a node as letters, one word per tick.

        Args:
            node: Path of the node, or its name if unique.

        Raises:
            InputError: No node, or more than one, has this name.
        """
        found = [path for path in self.cells if node in (path, path.rsplit("/", 1)[-1])]
        if not found:
            raise InputError(unknown("node", node, self.cells, "The tree"))
        if len(found) > 1 and node not in self.cells:
            raise InputError(Fault(f"{len(found)} nodes are named '{node}'.", hint=f"Choose one: {', '.join(found)}."))
        return " ".join(self.cells[node] if node in self.cells else self.cells[found[0]])

    def __str__(self) -> str:
        width = max(max(len(cell) for cell in row) for row in self.cells.values())
        lines = [
            f"{'  ' * path.count('/') + path.rsplit('/', 1)[-1]:<40} {' '.join(f'{c:<{width}}' for c in row)}".rstrip()
            for path, row in self.cells.items()
        ]
        ending = f"{self.outcome} after {self.ticks} ticks" + (f": {self.reason}" if self.reason else "")
        return "\n".join([*lines, ending])


class _Stub(Leaf):
    """Leaf that accepts any ports and fails unless it is substituted."""

    def __init__(self, name: str = "", /, **attributes: Any) -> None:
        kept = {n: v for n, v in attributes.items() if n.startswith("_")}
        super().__init__(name, **kept)

    @classmethod
    def attribute_faults(cls, attributes: Mapping[str, Any]) -> list[tuple[str, Fault]]:
        return super().attribute_faults({n: v for n, v in attributes.items() if n.startswith("_")})

    def update(self) -> Outcome:
        self.feedback_message = "this node has no class"
        return FAILURE


def stub_leaf(tag: str) -> type[Leaf]:
    """Return a stub class for the XML tag of a node without a class."""
    return type(tag, (_Stub,), {"tag": tag, "__doc__": "Stub of a node without a class."})
