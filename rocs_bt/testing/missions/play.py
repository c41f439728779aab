"""play: a mission from its first tick to its last, without a robot."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...catalog import Catalog
from ...errors import Fault, InputError
from ...event import Said
from ...plan import Act, Mission, mission_actions, mission_arguments, mission_nodes, xml_mission
from ...trees.nodes import BUILTIN, RUNNING, Decorator, Node, Tree
from ...trees.status import FAILURE, IDLE, Outcome, outcome_name
from .coverage import TreeCoverage, outline
from .inject import inject
from .letters import Letters
from .match import wild
from .mind import Known, Surroundings, checked_ticks
from .stub import stub
from .substitute import Rule, substitute
from .trace import Trace

if TYPE_CHECKING:
    from ...trees import Behaviour

LETTERS = {"RUNNING": "R", "SUCCESS": "S", "FAILURE": "F", "SKIPPED": "K", "IDLE": "H"}


@dataclass(frozen=True, kw_only=True)
class PlayOptions:
    """What a mission meets while it is played, for `play`.

    Attributes:
        leaves: Outcomes of leaves, by filter: a letter per tick; see `substitute`. A leaf in XML whose class does not
            exist is made up if it is named here.
        rules: Other stubs, by filter.
        faults: Decorators to put around nodes, by filter; see `inject`.
        knowledge: Knowledge at the start.
        signals: Values of the signals, such as `{"front": "0.4 m"}`.
        parameters: The mission's parameters, as a scenario's file gives them.
        board: Values on the root's board.
        then: Functions that run before a tick, by its number, counted from 1.
        ticks: Maximum number of ticks.
        step: Time between ticks, on a clock that nothing else moves [s].
        settle: Whether each tick goes on until nothing can be done without time passing.
        main: The tree of the document that is played; its main tree if empty.
        catalog: Source of content; the project around the current folder, and ours, by default.
        coverage: Counts statuses of nodes.
    """

    leaves: Mapping[str, str | Letters] = field(default_factory=dict)
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
        mission: The name or path of a mission, the text of an XML document, or a Python mission's `build`.
        options: What it meets.
        changes: Attributes of `PlayOptions` as keywords, which replace those of `options`.

    Returns:
        Statuses of all nodes, tick by tick.

    Raises:
        InputError: The mission is wrong, a filter matches no node, or a leaf would need a robot; or TreeError, where a
            node cannot go on.
    """
    given = replace(options, **changes)
    catalog, letters = given.catalog or Catalog.here(), _letters(given.leaves)
    build, name = _build(mission, catalog, letters, given.main)
    actions = mission_actions(build)
    around = Surroundings(given.knowledge, given.signals, step=given.step, actions=actions, content=catalog, name=name)
    own = around.mission
    root = build(own, **mission_arguments(build, given.parameters))
    if letters or given.rules:
        every = mission_nodes(own.actions, catalog.load_nodes())
        root = substitute(root, {**letters, **given.rules}, every)
    if given.faults:
        root = inject(root, given.faults)
    _refuse_robots(root)
    tree = Tree(root, board=own.board, clock=around.clock, owner=own)
    own.board.update(given.board)
    return _Player(tree, around, given.coverage).play(checked_ticks(given.ticks), given.then, given.settle)


class _Player:
    def __init__(self, tree: Tree, around: Surroundings, coverage: TreeCoverage | None) -> None:
        self.tree, self.around = tree, around
        self.paths = {node.id: path for node, path, _ in outline(tree.root)}
        self.cells: dict[str, list[str]] = {path: [] for path in self.paths.values()}
        self.outcomes: list[str] = []
        self.times: list[float] = []
        tree.watch(self._hear)
        self.strangers = {node: IDLE for node in tree.nodes if not isinstance(node, Node)}
        self.look = coverage.watch(around.mission.name, tree) if coverage is not None else lambda: None

    def play(self, ticks: int, then: Mapping[int, Callable[[Mission], None]], settle: bool) -> Trace:
        mission, clock = self.around.mission, self.around.clock
        for tick in range(1, ticks + 1):
            if tick in then:
                then[tick](mission)
            for row in self.cells.values():
                row.append("")
            mission.begin(clock.now(), self.paths)
            outcome = self.tree.settle() if settle else self.tree.tick()
            self._strangers(outcome)
            self.look()
            self.outcomes.append(outcome_name(outcome))
            self.times.append(clock.now())
            clock.advance()
            if outcome is not RUNNING:
                break
        return Trace(
            tuple(self.outcomes),
            {path: tuple(cell or "." for cell in row) for path, row in self.cells.items()},
            self.tree.board,
            self.around.knowledge,
            tuple(e.text for e in self.around.sink.events if isinstance(e, Said)),
            self._reason(outcome),
            tuple(self.times),
        )

    def _hear(self, node: Behaviour, outcome: Outcome) -> None:
        if node.id in self.paths:
            self.cells[self.paths[node.id]][-1] += LETTERS[outcome_name(outcome)]

    def _strangers(self, outcome: Outcome) -> None:
        """py_trees' own nodes tell nobody what they come to: what changed, and what runs, is looked up."""
        for node, before in self.strangers.items():
            if node.status is RUNNING or node.status is not before or node is self.tree.root:
                self._hear(node, outcome if node is self.tree.root else node.status)
                self.strangers[node] = node.status

    def _reason(self, outcome: Outcome) -> str:
        if outcome is not FAILURE:
            return ""
        tip = self.tree.root.tip() or self.tree.root
        return str(tip.feedback_message)


def _letters(leaves: Mapping[str, str | Letters]) -> dict[str, Rule]:
    return {text: Letters(given) if isinstance(given, str) else given for text, given in leaves.items()}


def _build(
    mission: str | Path | Callable[..., Any], catalog: Catalog, letters: Iterable[str], main: str
) -> tuple[Callable[..., Any], str]:
    """The function that makes the tree, and the mission's name."""
    if callable(mission):
        return mission, getattr(mission, "__name__", "mission")

    def nodes(tags: set[str]) -> list[Any]:
        return _nodes(catalog, tags, letters)

    def others(name: str) -> Callable[..., Any] | None:
        there = any(e.name == name and e.path.suffix == ".py" for e in catalog.list("mission"))
        return catalog.load_mission(name) if there else None

    if isinstance(mission, str) and mission.lstrip().startswith("<"):
        return xml_mission(mission, main=main, nodes=nodes, missions=others), main or "mission"
    entry = catalog.find("mission", str(mission))
    if entry.path.suffix != ".xml":
        return catalog.load_mission(str(entry.path)), entry.name
    root = catalog.root_of(entry.path)
    return xml_mission(entry.path, main=main, within=root, nodes=nodes, missions=others), entry.name


def _nodes(catalog: Catalog, tags: Iterable[str], letters: Iterable[str]) -> list[Any]:
    """A project's nodes among these, and made-up ones for those that nobody has and that have letters."""
    from ...actions import ACTIONS

    unknown = set(tags) - {*BUILTIN, *ACTIONS}
    found = catalog.load_nodes(unknown)
    missing = unknown - {node.tag for node in found}
    return [*found, *(stub(tag) for tag in sorted(missing) if tag in set(letters) and not wild(tag))]


def _refuse_robots(root: Behaviour) -> None:
    """Refuse leaves that have actions done: nobody would do them."""
    names = sorted({node.name for node, _, _ in outline(root) if isinstance(node, Act)})
    if names:
        hint = f'Give them letters, as in leaves={{"{names[0]}": "RRS"}}, or all of them: leaves={{"*": "S"}}.'
        raise InputError(Fault(f"these leaves need a robot: {', '.join(names)}.", hint=hint))
