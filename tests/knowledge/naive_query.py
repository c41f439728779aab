"""Queries as data, and what they mean as plainly as it can be told: every assignment is tried, nothing is indexed."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise, product
from typing import Any

from rocs_bt.base.geometry import Pose2
from rocs_bt.knowledge import Readable


@dataclass(frozen=True)
class Var:
    name: str
    kind: str

    def __str__(self) -> str:
        return self.kind if self.name == self.kind else f"{self.kind} {self.name}"


@dataclass(frozen=True)
class Hop:
    source: Var
    relation: str
    target: Var
    sign: str = ""  # "", "+" or "*"

    def __str__(self) -> str:
        return f"{self.source} {self.relation}{self.sign} {self.target}"


@dataclass(frozen=True)
class Atom:
    """`text` as it stands in a query; `form` and `parts` for the interpreter."""

    text: str
    form: str
    parts: tuple[Any, ...]

    def __str__(self) -> str:
        return self.text


@dataclass(frozen=True)
class Junction:
    word: str  # and, or, not
    parts: tuple[Any, ...]

    def __str__(self) -> str:
        if self.word == "not":
            return f"not ({self.parts[0]})"
        return f" {self.word} ".join(f"({part})" for part in self.parts)


@dataclass(frozen=True)
class Asked:
    """A query as data."""

    hops: tuple[Hop, ...]
    alone: tuple[Var, ...] = ()
    absent: tuple[Hop, ...] = ()
    where: Atom | Junction | None = None
    order: tuple[Atom, bool] | None = None
    limit: int | None = None
    since: int | None = None
    shown: tuple[Var, ...] = field(default=())

    def __str__(self) -> str:
        clauses = [*map(str, self.alone), *map(str, self.hops), *(f"no {hop}" for hop in self.absent)]
        text = ", ".join(clauses)
        if self.where is not None:
            text += f" where {self.where}"
        if self.order is not None:
            text += f" order by {self.order[0]}{' descending' if self.order[1] else ''}"
        text += "" if self.limit is None else f" limit {self.limit}"
        return text if self.since is None else f"{text} changed since {self.since}"


def answers(asked: Asked, graph: Readable, here: Pose2 | None) -> list[tuple[str, ...]]:
    """What the query should give, in order."""
    edges = {(s, r, t): graph.targets(s, r)[t] for s, r, t in graph.edges()}
    found = []
    for row in product(*(of_kind(graph, var.kind) for var in asked.shown)):
        names = {var.name: name for var, name in zip(asked.shown, row, strict=True)}
        if (
            all(linked(graph, edges, hop, names) for hop in asked.hops)
            and not any(possible(graph, edges, hop, names) for hop in asked.absent)
            and (asked.where is None or value(asked.where, graph, names, here) is True)
            and (asked.since is None or changed(asked, graph, edges, names))
        ):
            found.append((row, names))

    def key(each: tuple[tuple[str, ...], dict[str, str]]) -> tuple[Any, ...]:
        row, names = each
        if asked.order is None:
            return (row,)
        number = value(asked.order[0], graph, names, here)
        sign = -1.0 if asked.order[1] else 1.0
        return (number is None, 0.0 if number is None else sign * number, row)

    return [row for row, _ in sorted(found, key=key)][: asked.limit]


def of_kind(graph: Readable, kind: str) -> list[str]:
    return [name for name in graph.nodes() if graph.schema.is_a(graph.kind(name), kind)]


def linked(graph: Readable, edges: Any, hop: Hop, names: dict[str, str]) -> bool:
    source, target = names[hop.source.name], names[hop.target.name]
    if not hop.sign:
        return (source, hop.relation, target) in edges
    reached = {source} if hop.sign == "*" else {t for s, r, t in edges if (s, r) == (source, hop.relation)}
    for _ in graph.nodes():
        reached |= {t for s, r, t in edges if r == hop.relation and s in reached}
    return target in reached


def possible(graph: Readable, edges: Any, hop: Hop, names: dict[str, str]) -> bool:
    """Whether any thing of the kinds that the names leave open makes the hop."""
    free = [var for var in (hop.source, hop.target) if var.name not in names]
    for row in product(*(of_kind(graph, var.kind) for var in free)):
        trial = {**names, **{var.name: name for var, name in zip(free, row, strict=True)}}
        if linked(graph, edges, hop, trial):
            return True
    return False


def changed(asked: Asked, graph: Readable, edges: Any, names: dict[str, str]) -> bool:
    rows: list[Any] = [graph.row(name) for name in names.values()]
    rows += [edges[names[h.source.name], h.relation, names[h.target.name]] for h in asked.hops if not h.sign]
    return any(row["revision"] > asked.since for row in rows)


def value(node: Atom | Junction, graph: Readable, names: dict[str, str], here: Pose2 | None) -> Any:
    """The value of an expression; None where it is not known. Truth is three-valued (Kleene)."""
    if isinstance(node, Atom):
        return atom(node, graph, names, here)
    values = [value(part, graph, names, here) for part in node.parts]
    if node.word == "not":
        return None if values[0] is None else not values[0]
    decisive = node.word == "or"
    if decisive in values:
        return decisive
    return None if None in values else not decisive


def atom(node: Atom, graph: Readable, names: dict[str, str], here: Pose2 | None) -> Any:
    match node.form, node.parts:
        case "attribute", (var, name):
            return graph.get(names[var], name)
        case "less", (left, bound):
            number = atom(left, graph, names, here)
            return None if number is None else number < bound
        case "distance", (var, other):
            asker = here or place(graph, {}, "R2", None)
            poses = [place(graph, names, var, here), asker if other == "robot" else place(graph, names, other, here)]
            return None if None in poses else math.hypot(poses[0].x - poses[1].x, poses[0].y - poses[1].y)
        case "same", (var, other):
            return names[var] == names.get(other, other)
        case "kind", (var, kind):
            return graph.kind(names[var]) == kind
        case "known", (var, "pose"):
            return place(graph, names, var, here) is not None
    raise AssertionError(node)


def place(graph: Readable, names: dict[str, str], other: str, here: Pose2 | None) -> Pose2 | None:
    """Where something is; the robot that asks knows best itself."""
    node = names.get(other, other)
    if node == "R2" and here is not None:
        return here
    pose: Pose2 | None = graph.get(node, "pose") if graph.has(node) else None
    return pose


def beside(pose: Pose2, path: Sequence[tuple[float, float]]) -> float:
    """By many points on each leg; so a test compares it with some slack."""
    return min(math.hypot(pose.x - x, pose.y - y) for x, y in points(path))


def points(path: Sequence[tuple[float, float]]) -> Iterator[tuple[float, float]]:
    yield path[0]
    for (ax, ay), (bx, by) in pairwise(path):
        for i in range(1, 401):
            yield ax + (bx - ax) * i / 400, ay + (by - ay) * i / 400
