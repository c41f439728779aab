"""The steps of a query: each finds a thing, or tests what was found; together they walk through all that fits."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from heapq import merge
from itertools import chain
from operator import itemgetter
from typing import Any

from .context import Execution
from .parameter import circle
from .pattern import Link

Row = Mapping[str, Any]
Code = Callable[["State"], Any]
_NAME: Callable[[tuple[float, str]], str] = itemgetter(1)


class State:
    """What was found so far; the steps fill it in and take it back.

    Attributes:
        n: The name of each variable.
        r: Its row.
        e: The row of each link's edge.
        c: What holds for the whole run.
    """

    __slots__ = ("c", "e", "n", "r")

    def __init__(self, variables: int, links: int, execution: Execution) -> None:
        self.n: list[Any] = [None] * variables
        self.r: list[Any] = [None] * variables
        self.e: list[Any] = [None] * links
        self.c = execution


@dataclass(frozen=True)
class Near:
    """Look only so far around something.

    Attributes:
        place: Gives the pose or path around which to look.
        within: How far at most [m].
        sorted: Whether the nearest must come first, and those whose pose is not known last.
        own: Whether the robot that asks is of the kind that is looked for.
    """

    place: Code
    within: float
    sorted: bool = False
    own: bool = False


@dataclass(frozen=True)
class Scan:
    """Find a thing among all of its kind."""

    variable: int
    kind: str
    near: Near | None
    test: Code | None

    def run(self, state: State) -> Iterator[None]:
        i, names, rows, row_of, test = self.variable, state.n, state.r, state.c.graph.row, self.test
        for name in self._names(state):
            row = row_of(name)
            if row is not None:
                names[i], rows[i] = name, row
                if test is None or test(state):
                    yield
        names[i] = rows[i] = None

    def _names(self, state: State) -> Iterable[str]:
        near, graph = self.near, state.c.graph
        if near is None:
            return graph.nodes(self.kind)
        place = near.place(state)
        if place is None:
            return sorted(graph.nodes(self.kind)) if near.sorted else ()
        names = map(_NAME, self._by_distance(near, place, state.c))
        return chain(names, self._nowhere(near, place, state.c)) if near.sorted else names

    def _by_distance(self, near: Near, place: Any, c: Execution) -> Iterator[tuple[float, str]]:
        x, y, reach = circle(place)
        found = c.graph.by_distance(x, y, self.kind, near.within + reach)
        return self._with_robot(found, c, x, y) if near.own and c.me is not None else found

    def _nowhere(self, near: Near, place: Any, c: Execution) -> Iterator[str]:
        """The names of those whose pose is not known; nothing is looked at before one asks for the first."""
        somewhere = set(map(_NAME, self._by_distance(near, place, c)))
        yield from (name for name in sorted(c.graph.nodes(self.kind)) if name not in somewhere)

    def _with_robot(
        self, found: Iterator[tuple[float, str]], c: Execution, x: float, y: float
    ) -> Iterator[tuple[float, str]]:
        """The same with the robot that asks, which is where it knows itself to be, and not where the graph says."""
        others = (each for each in found if each[1] != c.me)
        here, me = c.here, c.me
        if here is None or me is None or c.graph.row(me) is None:
            return others
        return merge(others, [(math.hypot(here.x - x, here.y - y), me)])


@dataclass(frozen=True)
class Pin:
    """Take the one thing of a name."""

    variable: int
    kinds: frozenset[str] | None
    name: Code

    def run(self, state: State) -> Iterator[None]:
        name = self.name(state)
        row = None if name is None else state.c.graph.row(name)
        if row is not None and (self.kinds is None or row["kind"] in self.kinds):
            state.n[self.variable], state.r[self.variable] = name, row
            yield
            state.n[self.variable] = state.r[self.variable] = None


@dataclass(frozen=True)
class Follow:
    """Find a thing at the other end of a link."""

    link: Link
    edge: int
    forward: bool
    kinds: frozenset[str] | None

    def run(self, state: State) -> Iterator[None]:
        link, graph = self.link, state.c.graph
        here, i = (link.source, link.target) if self.forward else (link.target, link.source)
        for name, edge in _ends(state, link, state.n[here], self.forward):
            row = graph.row(name)
            if row is not None and (self.kinds is None or row["kind"] in self.kinds):
                state.n[i], state.r[i] = name, row
                if self.edge >= 0:
                    state.e[self.edge] = edge
                yield
        state.n[i] = state.r[i] = None


@dataclass(frozen=True)
class Joined:
    """Whether two variables that were found are linked."""

    link: Link
    edge: int

    def run(self, state: State) -> Iterator[None]:
        link, source, target = self.link, state.n[self.link.source], state.n[self.link.target]
        if link.plain:
            edge = state.c.graph.targets(source, link.relation.name).get(target)
            if edge is not None:
                if self.edge >= 0:
                    state.e[self.edge] = edge
                yield
        elif any(name == target for name, _ in _ends(state, link, source, True)):
            yield


@dataclass(frozen=True)
class Test:
    """Whether an expression holds."""

    holds: Code

    def run(self, state: State) -> Iterator[None]:
        if self.holds(state):
            yield


@dataclass(frozen=True)
class Absent:
    """Whether nothing fits some steps."""

    steps: Sequence[Step]

    def run(self, state: State) -> Iterator[None]:
        if not any(True for _ in walk(self.steps, state)):
            yield


Step = Scan | Pin | Follow | Joined | Test | Absent


def walk(steps: Sequence[Step], state: State, at: int = 0) -> Iterator[None]:
    """Every way through the steps: the state holds what was found while the caller looks at it."""
    left = len(steps) - at
    return steps[at].run(state) if left == 1 else _walk(steps, state, at) if left else iter((None,))


def _walk(steps: Sequence[Step], state: State, at: int) -> Iterator[None]:
    for _ in steps[at].run(state):
        yield from walk(steps, state, at + 1)


def _ends(state: State, link: Link, name: str, forward: bool) -> Iterator[tuple[str, Row | None]]:
    """What a link leads to from a node, with the row of the edge where it is a plain one."""
    graph, relation = state.c.graph, link.relation.name
    ends = graph.targets if forward else graph.sources
    if link.plain:
        yield from ends(name, relation).items()
        return
    if link.steps[0] == 0:
        yield name, None
    seen, waiting = {name} if link.steps[0] == 0 else set(), [name]
    while waiting:
        for found in ends(waiting.pop(), relation):
            if found not in seen:
                seen.add(found)
                waiting.append(found)
                yield found, None
