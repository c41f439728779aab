"""Inputs of a query besides the graph: the querying robot, its pose, the time, its signals and its past."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from ...base.geometry import Pose2
from ..history import ChangeLog
from ..readable import Readable


def _no_signal(name: str) -> Sequence[float]:
    return ()


class QueryContext(NamedTuple):
    """Inputs of a query besides the graph.

    Attributes:
        name: Node of the querying robot; empty without a robot.
        pose: Pose of the robot, world frame; None if unknown.
        t: Query time [s].
        signal: Returns the newest values of a signal by name.
        past: Log of earlier changes for `as of`; None without one.
    """

    name: str = ""
    pose: Pose2 | None = None
    t: float = 0.0
    signal: Callable[[str], Sequence[float]] = _no_signal
    past: ChangeLog | None = None


class Execution:
    """Data of one execution of a query, named `c` in the query's generated code."""

    __slots__ = ("graph", "here", "k", "me", "p", "s", "t")

    def __init__(
        self,
        graph: Readable,
        context: QueryContext,
        parameters: Mapping[str, Any],
        texts: Sequence[str],
        signals: Mapping[str, int],
    ) -> None:
        self.graph = graph
        self.me = context.name or None
        self.t = context.t
        self.p = parameters
        self.k = texts
        self.here = context.pose
        if self.here is None and self.me is not None:
            self.here = self.where(self.me)
        self.s = {name: context.signal(name) or (math.nan,) * size for name, size in signals.items()} if signals else {}

    def where(self, node: str) -> Pose2 | None:
        """The pose of a node; None if unknown."""
        if node == self.me and self.here is not None:
            return self.here
        row = self.graph.row(node)
        pose = None if row is None else row.get("pose")
        return pose if isinstance(pose, Pose2) else None

    def age(self, node: str | None, attribute: str | None) -> float:
        """Time since a node, or one of its attributes, was written [s]; NaN if there is no such node."""
        if node is None or self.graph.row(node) is None:
            return math.nan
        return self.t - self.graph.stamp(node, attribute).t
