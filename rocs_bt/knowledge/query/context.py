"""QueryContext: who asks, where it is and when; what a query reads beside the graph."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from ...geometry import Pose2
from ..readable import NoPast, Past, Readable


def _no_signal(name: str) -> Sequence[float]:
    return ()


class QueryContext(NamedTuple):
    """Who asks.

    Attributes:
        name: The robot's node; empty where no robot asks.
        pose: Where it is, in the world frame; None where that is not known.
        t: When it asks [s].
        signal: The newest values of one of its signals.
        past: Where `as of` looks.
    """

    name: str = ""
    pose: Pose2 | None = None
    t: float = 0.0
    signal: Callable[[str], Sequence[float]] = _no_signal
    past: Past = NoPast()


class Execution:
    """What holds for one run of a query: `c` in its generated code.

    Args:
        graph: What is asked.
        context: Who asks.
        parameters: The values of the parameters.
        texts: The query's texts in quotes.
        signals: The signals that it reads, with their sizes.
    """

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
        """The pose of a node; None where it is not known."""
        if node == self.me and self.here is not None:
            return self.here
        row = self.graph.row(node)
        pose = None if row is None else row.get("pose")
        return pose if isinstance(pose, Pose2) else None

    def age(self, node: str | None, attribute: str | None) -> float:
        """How long ago a node, or one of its attributes, was written [s]; NaN where there is no such node."""
        if node is None or self.graph.row(node) is None:
            return math.nan
        return self.t - self.graph.stamp(node, attribute).t
