"""Steps of a query plan: each binds a variable to nodes or tests the bindings; together they enumerate the matches."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from heapq import merge
from itertools import chain, compress, islice
from operator import itemgetter
from typing import Any, Protocol

from .context import Execution
from .parameter import circle
from .pattern import Link

Row = Mapping[str, Any]
Code = Callable[["Match"], Any]
_NAME: Callable[[tuple[float, str]], str] = itemgetter(1)


class Match:
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


class Condition(Protocol):
    """Condition that is tested for several states at once."""

    @property
    def read(self) -> Code:
        """Values that the condition depends on in one state."""
        ...

    def hold(self, rows: Sequence[Sequence[float]]) -> list[bool]:
        """Whether the condition holds for several results of `read`."""
        ...


@dataclass(frozen=True)
class Scan:
    """Bind a variable to each node of a kind in turn."""

    variable: int
    kind: str
    near: Near | None
    test: Condition | None

    def run(self, match: Match) -> Iterator[None]:
        i, names, rows = self.variable, match.n, match.r
        for names[i], rows[i] in self._nodes(match) if self.test is None else self._tested(self.test, match):
            yield
        names[i] = rows[i] = None

    def _nodes(self, match: Match) -> Iterator[tuple[str, Row]]:
        row_of = match.c.graph.row
        return ((name, row) for name in self._names(match) if (row := row_of(name)) is not None)

    def _tested(self, test: Condition, match: Match) -> Iterator[tuple[str, Row]]:
        """Nodes for which the condition holds; it is tested for more and more nodes at once, as few may be wanted."""
        i, names, rows, nodes, size = self.variable, match.n, match.r, self._nodes(match), 8
        while some := list(islice(nodes, size)):
            values = []
            for names[i], rows[i] in some:
                values.append(test.read(match))
            yield from compress(some, test.hold(values))
            size = min(4 * size, 1024)

    def _names(self, match: Match) -> Iterable[str]:
        near, graph = self.near, match.c.graph
        if near is None:
            return graph.nodes(self.kind)
        place = near.place(match)
        if place is None:
            return sorted(graph.nodes(self.kind)) if near.sorted else ()
        names = map(_NAME, self._by_distance(near, place, match.c))
        return chain(names, self._without_pose(near, place, match.c)) if near.sorted else names

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

    def run(self, match: Match) -> Iterator[None]:
        name = self.name(match)
        row = None if name is None else match.c.graph.row(name)
        if row is not None and (self.kinds is None or row["kind"] in self.kinds):
            match.n[self.variable], match.r[self.variable] = name, row
            yield
            match.n[self.variable] = match.r[self.variable] = None


@dataclass(frozen=True)
class Follow:
    """Bind a variable to each node in turn that a link joins to a bound variable."""

    link: Link
    edge: int
    forward: bool
    kinds: frozenset[str] | None

    def run(self, match: Match) -> Iterator[None]:
        link, graph = self.link, match.c.graph
        here, i = (link.source, link.target) if self.forward else (link.target, link.source)
        for name, edge in _ends(match, link, match.n[here], self.forward):
            row = graph.row(name)
            if row is not None and (self.kinds is None or row["kind"] in self.kinds):
                match.n[i], match.r[i] = name, row
                if self.edge >= 0:
                    match.e[self.edge] = edge
                yield
        match.n[i] = match.r[i] = None


@dataclass(frozen=True)
class Joined:
    """Test whether the nodes of two bound variables are linked."""

    link: Link
    edge: int

    def run(self, match: Match) -> Iterator[None]:
        link, source, target = self.link, match.n[self.link.source], match.n[self.link.target]
        if link.plain:
            edge = match.c.graph.targets(source, link.relation.name).get(target)
            if edge is not None:
                if self.edge >= 0:
                    match.e[self.edge] = edge
                yield
        elif any(name == target for name, _ in _ends(match, link, source, True)):
            yield


@dataclass(frozen=True)
class Test:
    """Test an expression."""

    holds: Code

    def run(self, match: Match) -> Iterator[None]:
        if self.holds(match):
            yield


@dataclass(frozen=True)
class Absent:
    """Test that the steps of a `no` clause have no match."""

    steps: Sequence[Step]

    def run(self, match: Match) -> Iterator[None]:
        if not any(True for _ in walk(self.steps, match)):
            yield


Step = Scan | Pin | Follow | Joined | Test | Absent


def walk(steps: Sequence[Step], match: Match, at: int = 0) -> Iterator[None]:
    """Iterate over all matches of the steps from index `at` on; `match` is the present one."""
    left = len(steps) - at
    return steps[at].run(match) if left == 1 else _walk(steps, match, at) if left else iter((None,))


def _walk(steps: Sequence[Step], match: Match, at: int) -> Iterator[None]:
    for _ in steps[at].run(match):
        yield from walk(steps, match, at + 1)


def _ends(match: Match, link: Link, name: str, forward: bool) -> Iterator[tuple[str, Row | None]]:
    """Nodes that a link joins to the node `name`, each with the row of the edge; None for a chain of edges."""
    graph, relation = match.c.graph, link.relation.name
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
