"""Steps of a query plan: each binds a variable to nodes or tests the bindings; together they enumerate the matches."""

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
    """Partial match of a query: the nodes to which its variables are bound so far.

    Attributes:
        n: Name of the node bound to each variable; None while unbound.
        r: Row (stored attributes, see `Readable`) of that node. e: Row of the edge that each link has found; None while
            unbound.
        c: Data of this execution of the query.
    """

    __slots__ = ("c", "e", "n", "r")

    def __init__(self, variables: int, links: int, execution: Execution) -> None:
        self.n: list[Any] = [None] * variables
        self.r: list[Any] = [None] * variables
        self.e: list[Any] = [None] * links
        self.c = execution


@dataclass(frozen=True)
class Near:
    """Restriction of a scan to the surroundings of a pose or path.

    Attributes:
        place: Function of the State that returns the pose or path.
        within: Maximum distance of the nodes from the pose or path [m].
        sorted: Whether the nodes are wanted in order of distance, with those without a known pose last.
        own: Whether the querying robot may be of the scanned kind.
    """

    place: Code
    within: float
    sorted: bool = False
    own: bool = False


@dataclass(frozen=True)
class Scan:
    """Bind a variable to each node of a kind in turn."""

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
        return chain(names, self._without_pose(near, place, state.c)) if near.sorted else names

    def _by_distance(self, near: Near, place: Any, c: Execution) -> Iterator[tuple[float, str]]:
        x, y, reach = circle(place)
        found = c.graph.by_distance(x, y, self.kind, near.within + reach)
        return self._with_robot(found, c, x, y) if near.own and c.me is not None else found

    def _without_pose(self, near: Near, place: Any, c: Execution) -> Iterator[str]:
        """Names of the nodes without a known pose; they are computed when the first name is requested."""
        somewhere = set(map(_NAME, self._by_distance(near, place, c)))
        yield from (name for name in sorted(c.graph.nodes(self.kind)) if name not in somewhere)

    def _with_robot(
        self, found: Iterator[tuple[float, str]], c: Execution, x: float, y: float
    ) -> Iterator[tuple[float, str]]:
        """Replace the querying robot's distance in `found` by that of its own pose estimate."""
        others = (each for each in found if each[1] != c.me)
        here, me = c.here, c.me
        if here is None or me is None or c.graph.row(me) is None:
            return others
        return merge(others, [(math.hypot(here.x - x, here.y - y), me)])


@dataclass(frozen=True)
class Pin:
    """Bind a variable to one named node."""

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
    """Bind a variable to each node in turn that a link joins to a bound variable."""

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
    """Test whether the nodes of two bound variables are linked."""

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
    """Test an expression."""

    holds: Code

    def run(self, state: State) -> Iterator[None]:
        if self.holds(state):
            yield


@dataclass(frozen=True)
class Absent:
    """Test that the steps of a `no` clause have no match."""

    steps: Sequence[Step]

    def run(self, state: State) -> Iterator[None]:
        if not any(True for _ in walk(self.steps, state)):
            yield


Step = Scan | Pin | Follow | Joined | Test | Absent


def walk(steps: Sequence[Step], state: State, at: int = 0) -> Iterator[None]:
    """Iterate over all matches of the steps from index `at` on; `state` holds the present match."""
    left = len(steps) - at
    return steps[at].run(state) if left == 1 else _walk(steps, state, at) if left else iter((None,))


def _walk(steps: Sequence[Step], state: State, at: int) -> Iterator[None]:
    for _ in steps[at].run(state):
        yield from walk(steps, state, at + 1)


def _ends(state: State, link: Link, name: str, forward: bool) -> Iterator[tuple[str, Row | None]]:
    """Nodes that a link joins to the node `name`, each with the row of the edge; None for a chain of edges."""
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
