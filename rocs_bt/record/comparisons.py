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
_SIGNS = {"<": np.less, "<=": np.less_equal, ">": np.greater, ">=": np.greater_equal, "==": np.equal}


class Comparisons:
    """Adds the tracks of all guards to the tracks of a run.

    The topic `compare` has left side, right side and truth (1, 0 or NaN) of each comparison. `near`, of a guard, is 1
    while the guard is true. Else it is the ratio of the smaller to the larger side of a comparison; of an `and` the
    least of its parts, of an `or` the greatest.

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
        nodes = [part for tree in trees for part in tree.walk() if part.op == "compare"]
        self._when = trees[0]
        self._comparisons = [_Comparison(f"{info.rule}\n{i}", node) for i, node in enumerate(nodes)]
        units = (str(node.args[0].kind.dimension or "") for node in nodes)
        rows = zip(self._comparisons, info.comparisons, units, strict=True)
        listed = [{"name": c.name, "text": text, "unit": "" if unit == "1" else unit} for c, text, unit in rows]
        joined = self._joined(self._when)
        self.texts = {"when": info.when, "until": info.until, "comparisons": listed, "tree": joined}

    def rows(self, t: Sequence[float], x: Numbers) -> list[Numbers | None]:
        """Left side, right side and truth of each comparison at times, shape (n, 3); None if it cannot be evaluated."""
        return [comparison.rows(t, x) for comparison in self._comparisons]

    def add(self, tracks: Tracks, agent: str, t: Sequence[float], x: Numbers) -> None:
        """Add the comparisons at times to the tracks of an agent."""
        near: dict[Node, Numbers] = {}
        for comparison, rows in zip(self._comparisons, self.rows(t, x), strict=True):
            if rows is not None:
                tracks.curve(agent, "compare", comparison.name, 3).extend(t, rows)
                near[comparison.node] = _nearness(*rows.T)
        if (way := _combined(self._when, near)) is not None:
            tracks.curve(agent, "near", self.info.rule, 1).extend(t, way[:, None])

    def _joined(self, node: Node) -> Any:
        at = next((i for i, comparison in enumerate(self._comparisons) if comparison.node is node), None)
        if at is not None or not node.args:
            return at
        parts = [self._joined(arg) for arg in node.args]
        return parts[0] if node.op in ("any", "all") else [node.op, *parts]


class _Comparison:
    """One comparison of a guard; of a chain such as `a < b < c` the first."""

    def __init__(self, name: str, node: Node) -> None:
        self.name, self.node = name, node
        self._sides = [_Side(arg, least=(node.signs[0] in _LESS) == (i == 0)) for i, arg in enumerate(node.args[:2])]

    def rows(self, t: Sequence[float], x: Numbers) -> Numbers | None:
        """Left side, right side and truth, shape (n, 3); None if a side cannot be evaluated alone."""
        left, right = (side.values(t, x) for side in self._sides)
        if left is None or right is None:
            return None
        truth = _SIGNS.get(self.node.signs[0], np.not_equal)(left, right).astype(float)
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


def _nearness(left: Numbers, right: Numbers, truth: Numbers) -> Numbers:
    with np.errstate(invalid="ignore", divide="ignore"):
        part = 1.0 - np.abs(left - right) / np.maximum(np.abs(left), np.abs(right))
    part = np.clip(np.where(np.isfinite(part), part, 0.0), 0.0, 0.999)
    return np.where(np.isnan(truth), np.nan, np.where(truth > 0.0, 1.0, part))


def _combined(node: Node, near: dict[Node, Numbers]) -> Numbers | None:
    """Nearness of a condition from that of its comparisons; None if it has none."""
    if node in near:
        return near[node]
    if node.op in ("any", "all"):
        return near.get(node.args[0])
    if node.op not in ("and", "or"):
        return None
    parts = [part for arg in node.args if (part := _combined(arg, near)) is not None]
    if not parts:
        return None
    joined: Numbers = (np.fmin if node.op == "and" else np.fmax).reduce(parts)
    return joined
