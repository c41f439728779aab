"""play: a mission from its first tick to its last, without a robot."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
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


def play(
    mission: str | Path | Callable[..., Any],
    *,
    leaves: Mapping[str, str | Letters] | None = None,
    rules: Mapping[str, Rule] | None = None,
    faults: Mapping[str, Callable[[Behaviour], Decorator]] | None = None,
    knowledge: Known | None = None,
    signals: Mapping[str, Any] | None = None,
    parameters: Mapping[str, Any] | None = None,
    board: Mapping[str, Any] | None = None,
    then: Mapping[int, Callable[[Mission], None]] | None = None,
    ticks: int = 100,
    step: float = 0.1,
    settle: bool = False,
    main: str = "",
    catalog: Catalog | None = None,
    coverage: TreeCoverage | None = None,
) -> Trace:
    """Tick a mission until it ends, without a robot.

        trace = play("patrol", leaves={"GoTo": "RRS", "Speak": "S"}, knowledge={"dock": (1.0, 2.0)})
        assert trace.outcome == "SUCCESS"
        assert trace["GoTo dock"] == "R R S"

    Args:
        mission: The name or path of a mission, the text of an XML document, or a Python mission's `build`.
        leaves: What leaves come to, by filter: a letter a tick; see `substitute`. A leaf in XML whose class does not
            exist is made up when it is named here.
        rules: Other stand-ins, by filter.
        faults: Decorators to put around nodes, by filter; see `inject`.
        knowledge: What is known at the start.
        signals: What the signals read, such as `{"front": "0.4 m"}`.
        parameters: The mission's parameters, as a scenario's file gives them.
        board: Values on the root's board.
        then: What happens before a tick, by its number, counted from 1.
        ticks: How often it is ticked at most.
        step: How much time passes from tick to tick, on a clock that nothing else moves [s].
        settle: Whether each tick goes on until nothing can be done without time passing.
        main: The tree of the document that is played; its main tree by default.
        catalog: Where content is found; the project's around the current folder, and ours.
        coverage: Counts what was come to.

    Returns:
        What it did.

    Raises:
        InputError: The mission is wrong, a filter means no node, or a leaf would need a robot; or TreeError, where a
            node cannot go on.
    """
    catalog, letters = catalog or Catalog.here(), _letters(leaves or {})
    build, name = _build(mission, catalog, letters, main)
    around = Surroundings(
        knowledge or {}, signals or {}, step=step, actions=mission_actions(build), content=catalog, name=name
    )
    own = around.mission
    root = build(own, **mission_arguments(build, parameters or {}))
    if letters or rules:
        every = mission_nodes(own.actions, catalog.load_nodes())
        root = substitute(root, {**letters, **(rules or {})}, every)
    if faults:
        root = inject(root, faults)
    _refuse_robots(root)
    tree = Tree(root, board=own.board, clock=around.clock, owner=own)
    own.board.update(board or {})
    return _Player(tree, around, coverage).play(checked_ticks(ticks), then or {}, settle)


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
