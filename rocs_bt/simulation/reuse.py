"""What two scenarios share and what differs: content, code by what the built minds are made of, and settings.

The paper's claim is reuse: swapping the robot keeps the mission, swapping the task keeps the robot (6.2, Q2 and Q3).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from ..actions import action_table
from ..catalog import KINDS, AgentSpec, Catalog, Entry, MoverSpec, ScenarioSpec, content_hash
from ..event import NullSink
from .build_agents import load_controller
from .provenance import package_of, used_classes
from .ready_run import simulated_agents
from .settings import Setting, settings
from .simulated_world import build_world

Robot = AgentSpec | MoverSpec


@dataclass(frozen=True)
class Piece:
    """One piece of content that a scenario uses.

    Attributes:
        kind: One of the catalog's kinds.
        name: What people call it.
        content_hash: sha256 over its files.
        lines: How many lines of text its files have.
    """

    kind: str
    name: str
    content_hash: str
    lines: int


@dataclass(frozen=True)
class Share:
    """The things of one kind that two scenarios, or two agents, use.

    Attributes:
        kind: A kind of content, or a folder of the engine.
        both: What both use, and is the same.
        changed: What both use by one name, but is not the same.
        first: What only the first uses.
        second: What only the second uses.
    """

    kind: str
    both: tuple[str, ...]
    changed: tuple[str, ...]
    first: tuple[str, ...]
    second: tuple[str, ...]

    @property
    def same(self) -> bool:
        """Whether nothing differs."""
        return not (self.changed or self.first or self.second)


@dataclass(frozen=True)
class Counterpart:
    """A robot of the first scenario, and the one that takes its part in the second.

    Attributes:
        first: Its name there; empty where it has no counterpart.
        second: Its name there; empty where it has no counterpart.
        settings: What the scenarios say of them.
        code: The engine's classes that their minds are made of, by folder; none for robots without a mind.
    """

    first: str
    second: str
    settings: tuple[Setting, ...]
    code: tuple[Share, ...]

    def differing(self) -> tuple[str, ...]:
        """The settings that are not the same."""
        return tuple(setting.what for setting in self.settings if not setting.same)


@dataclass(frozen=True)
class Reuse:
    """What two scenarios share, and what differs.

    Attributes:
        first: The first scenario's name.
        second: The second scenario's name.
        content: By kind.
        code: The engine's classes that all minds of each are made of, by folder.
        settings: What they say; of their robots only who they are.
        robots: The robots, each beside its counterpart: of the same name, else the next that is left.
        pieces: Every piece of content of each scenario.
    """

    first: str
    second: str
    content: tuple[Share, ...]
    code: tuple[Share, ...]
    settings: tuple[Setting, ...]
    robots: tuple[Counterpart, ...]
    pieces: Mapping[str, tuple[Piece, ...]]


def diff(first: ScenarioSpec, second: ScenarioSpec, catalog: Catalog) -> Reuse:
    """Compare two scenarios; builds the minds of both, and runs neither.

    Args:
        first: The one to come from.
        second: The one to go to.
        catalog: Where their content is found.

    Raises:
        InputError: Something in the content is wrong.
    """
    pieces = [tuple(map(_piece, catalog.content_of(s))) for s in (first, second)]
    used = [_code(s, catalog) for s in (first, second)]
    classes = [{cls for mind in minds.values() for cls in mind} for minds in used]
    pairs = [*_pairs(first.agents, second.agents), *_pairs(first.movers, second.movers)]
    kinds = [k for k in KINDS if any(p.kind == k for p in (*pieces[0], *pieces[1]))]
    hashes = [{k: {p.name: p.content_hash for p in of if p.kind == k} for k in kinds} for of in pieces]
    return Reuse(
        first=first.name,
        second=second.name,
        content=tuple(_share(kind, *(of[kind] for of in hashes)) for kind in kinds),
        code=_by_room(*classes),
        settings=settings(first, second),
        robots=tuple(_counterpart(*pair, used) for pair in pairs),
        pieces={"first": pieces[0], "second": pieces[1]},
    )


def _piece(entry: Entry) -> Piece:
    lines = sum(file.read_bytes().count(b"\n") for file in entry.files())
    return Piece(entry.kind, entry.name, content_hash([entry]), lines)


def _code(scenario: ScenarioSpec, catalog: Catalog) -> dict[str, tuple[type, ...]]:
    """The engine's classes that each agent's mind is made of."""
    sink = NullSink()
    simulated = build_world(scenario, catalog, 1, sink)
    agents = simulated_agents(scenario, simulated, catalog, sink)
    found = {}
    for agent, spec in zip(agents, scenario.agents, strict=True):
        actions = action_table(*load_controller(scenario, spec, catalog).actions)
        found[agent.name] = used_classes(agent, (simulated.world, simulated.clock, sink), actions)
        agent.close()
    return found


def _by_room(first: Iterable[type], second: Iterable[type]) -> tuple[Share, ...]:
    """Classes by the engine's folders. There is one engine, so that nothing in it can be changed for one of the two."""
    sides = [{(package_of(cls), cls.__name__) for cls in classes} for classes in (first, second)]
    rooms = sorted({room for side in sides for room, _ in side})
    return tuple(_share(room, *({name: "" for at, name in side if at == room} for side in sides)) for room in rooms)


def _share(kind: str, first: Mapping[str, str], second: Mapping[str, str]) -> Share:
    """Names with their digests, on both sides."""
    common = sorted(first.keys() & second.keys())
    return Share(
        kind,
        both=tuple(name for name in common if first[name] == second[name]),
        changed=tuple(name for name in common if first[name] != second[name]),
        first=tuple(sorted(first.keys() - second.keys())),
        second=tuple(sorted(second.keys() - first.keys())),
    )


def _pairs(first: Sequence[Robot], second: Sequence[Robot]) -> Iterator[tuple[Robot | None, Robot | None]]:
    """Each robot and its counterpart: of the same name, else the next of those that are new."""
    there = {robot.name: robot for robot in second}
    new = [robot for robot in second if robot.name not in {r.name for r in first}]
    for robot in first:
        yield robot, there.get(robot.name) or (new.pop(0) if new else None)
    yield from ((None, robot) for robot in new)


def _counterpart(
    first: Robot | None, second: Robot | None, used: Sequence[Mapping[str, tuple[type, ...]]]
) -> Counterpart:
    names = ["" if robot is None else robot.name for robot in (first, second)]
    classes = [side.get(name, ()) for side, name in zip(used, names, strict=True)]
    return Counterpart(names[0], names[1], settings(first, second), _by_room(*classes))
