"""Comparisons of guards over a run: both sides of each, and how near each guard is to being true."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..errors import InputError
from ..expression import Expression, Node, compile_node, parse
from .header import AgentInfo, GuardInfo
from .samples import Numbers, environment_of, samples
from .tracks import Tracks

_LESS = ("<", "<=")
_ALMOST = 0.999  # the most of what is not true
_SIGNS = {"<": np.less, "<=": np.less_equal, ">": np.greater, ">=": np.greater_equal, "==": np.equal}


class Comparisons:
    """Adds the tracks of all guards to the tracks of a run.

    The topic `compare` has left side, right side and truth (1, 0 or NaN) of each comparison. `near`, of a guard, is 1
    while the guard is true, and only then. Else it is the ratio of the smaller to the larger side of a comparison that
    has to change; of an `and` the least of its parts, of an `or` the greatest. A chain is an `and` of its comparisons.

    Args:
        tracks: Tracks of the run, with its signals.
    """

    def __init__(self, tracks: Tracks) -> None:
        self._tracks = tracks
        self._done = {agent.name: -math.inf for agent in tracks.header.agents}
        self._guards = {agent.name: guards_of(agent) for agent in tracks.header.agents if agent.signals}

    def update(self, *, over: bool = False) -> None:
        """Add the comparisons of all control periods that are complete; of all if the run is over."""
        end = math.inf if over else self._tracks.end
        for agent in self._tracks.header.agents:
            guards = self._guards.get(agent.name)
            if not guards:
                continue
            t, x = samples(self._tracks, agent, self._done[agent.name], end)
            if t:
                self._done[agent.name] = t[-1]
                for guard in guards:
                    guard.add(self._tracks, agent.name, t, x)

    def texts(self) -> dict[str, dict[str, Any]]:
        """Texts of the guards by agent and rule; see `Guard`."""
        return {agent: {guard.info.rule: guard.texts for guard in guards} for agent, guards in self._guards.items()}


def guards_of(agent: AgentInfo) -> list[Guard]:
    """Guards of an agent's rules; without those that only their rule file can read."""
    found = []
    environment = environment_of(agent)
    for info in agent.guards:
        try:
            found.append(Guard(info, [parse(text, environment) for text in info.sources]))
        except InputError:  # a guard with names that only its rule file knows
            continue
    return found


class Guard:
    """Guard of one rule: its compiled comparisons.

    Attributes:
        info: Description of the guard.
        texts: Its texts, with texts and units of the comparisons. `tree` tells how those of `when` are joined: the
            index of a comparison, or a list with the operation first; None for what is no comparison.
    """

    def __init__(self, info: GuardInfo, trees: Sequence[Node]) -> None:
        self.info = info
        self._when = trees[0]
        every = {id(arg) for tree in trees for part in tree.walk() if part.op == "all" for arg in part.args}
        whole = [part for tree in trees for part in tree.walk() if part.op == "compare"]
        pairs = [(node, pair) for node in whole for pair in node.pairs]
        self._comparisons = [
            _Comparison(f"{info.rule}\n{i}", node, pair, every=id(node) in every)
            for i, (node, pair) in enumerate(pairs)
        ]
        self._truth = None if self._when.future else compile_node(self._when)
        units = (str(pair.args[0].kind.dimension or "") for _, pair in pairs)
        rows = zip(self._comparisons, info.comparisons, units, strict=True)
        listed = [{"name": c.name, "text": text, "unit": "" if unit == "1" else unit} for c, text, unit in rows]
        self._tree = self._joined(self._when)
        self.texts = {"when": info.when, "until": info.until, "comparisons": listed, "tree": self._tree}

    def rows(self, t: Sequence[float], x: Numbers) -> list[Numbers | None]:
        """Left side, right side and truth of each comparison at times, shape (n, 3); None if it cannot be evaluated."""
        return [comparison.rows(t, x) for comparison in self._comparisons]

    def add(self, tracks: Tracks, agent: str, t: Sequence[float], x: Numbers) -> None:
        """Add the comparisons at times to the tracks of an agent."""
        found = self.rows(t, x)
        for comparison, rows in zip(self._comparisons, found, strict=True):
            if rows is not None:
                tracks.curve(agent, "compare", comparison.name, 3).extend(t, rows)
        if (way := _combined(self._tree, found, want=True)) is not None:
            if (truth := self._truth) is not None:  # parts that look the same must not say what is not so
                true = [truth(row, when) is True for row, when in zip(x, t, strict=True)]
                way = np.where(true, 1.0, np.minimum(way, _ALMOST))
            tracks.curve(agent, "near", self.info.rule, 1).extend(t, way[:, None])

    def _joined(self, node: Node) -> Any:
        at = [i for i, comparison in enumerate(self._comparisons) if comparison.node is node]
        if at:
            return at[0] if len(at) == 1 else ["and", *at]
        if not node.args:
            return None
        parts = [self._joined(arg) for arg in node.args]
        return parts[0] if node.op in ("any", "all") else [node.op, *parts]


class _Comparison:
    """One comparison of two sides in a guard.

    Args:
        name: Name of its track.
        node: The comparison as written, perhaps a chain.
        pair: The part of it with these two sides.
        every: Whether it has to hold for every value of a group; else for any.
    """

    def __init__(self, name: str, node: Node, pair: Node, *, every: bool) -> None:
        self.name, self.node, self._sign = name, node, pair.signs[0]
        small = (self._sign in _LESS) is not every
        self._sides = [_Side(arg, least=small == (i == 0)) for i, arg in enumerate(pair.args)]

    def rows(self, t: Sequence[float], x: Numbers) -> Numbers | None:
        """Left side, right side and truth, shape (n, 3); None if a side cannot be evaluated alone."""
        left, right = (side.values(t, x) for side in self._sides)
        if left is None or right is None:
            return None
        truth = _SIGNS.get(self._sign, np.not_equal)(left, right).astype(float)
        truth[np.isnan(left) | np.isnan(right)] = np.nan
        return np.stack([left, right, truth], axis=1)


class _Side:
    """One side of a comparison; of a group the value that decides: the least if it is to be small."""

    def __init__(self, node: Node, *, least: bool) -> None:
        self._node, self._least = node, least
        self._compiled: Expression | None = None if node.op == "read" or node.kind.size else compile_node(node)

    def values(self, t: Sequence[float], x: Numbers) -> Numbers | None:
        node, compiled = self._node, self._compiled
        if node.op == "read" and node.kind.size:
            group: Numbers = (np.fmin if self._least else np.fmax).reduce(x[:, node.start : node.stop], axis=1)
            return group
        if node.op == "read":
            return x[:, node.start]
        if compiled is None:
            return None
        return np.array([math.nan if (v := compiled(row, when)) is None else v for row, when in zip(x, t, strict=True)])


def _nearness(left: Numbers, right: Numbers, truth: Numbers, *, want: bool) -> Numbers:
    with np.errstate(invalid="ignore", divide="ignore"):
        part = 1.0 - np.abs(left - right) / np.maximum(np.abs(left), np.abs(right))
    part = np.clip(np.where(np.isfinite(part), part, 0.0), 0.0, _ALMOST)
    return np.where(np.isnan(truth), np.nan, np.where(truth == float(want), 1.0, part))


def _combined(tree: Any, rows: Sequence[Numbers | None], *, want: bool) -> Numbers | None:
    """How near a condition is to a truth, from the rows of its comparisons; None if they do not tell it."""
    if tree is None:
        return None
    if isinstance(tree, int):
        return None if (found := rows[tree]) is None else _nearness(*found.T, want=want)
    op, *args = tree
    if op == "not":
        return _combined(args[0], rows, want=not want)
    if op not in ("and", "or"):
        return None
    parts = [part for arg in args if (part := _combined(arg, rows, want=want)) is not None]
    if not parts:
        return None
    joined: Numbers = (np.fmin if (op == "and") is want else np.fmax).reduce(parts)
    return joined
