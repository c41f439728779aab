"""PassRange: whether something stands near."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

from ..channel import Signals, Stamped
from ..errors import InputError
from ..event import Change
from .analyze import Analyze


class PassRange(Analyze):
    """Keeps one `object` node per group of beams in the graph while something is near on it, and tells Plan.

    Args:
        groups: The groups to look at.
        near: Closer than this is near [m].
        clear: Farther than this is no longer near [m]; above `near`, so that it does not flicker.
    """

    def __init__(
        self,
        *args: Any,
        groups: Sequence[str] = ("front", "rear"),
        near: float = 0.6,
        clear: float = 0.8,
        **kwargs: Any,
    ) -> None:
        super().__init__(*args, **kwargs)
        if not 0.0 < near < clear < math.inf:
            raise InputError(f"near must be above 0 m and below clear, found {near:g} m and {clear:g} m.")
        self._groups = tuple(groups)
        self._near = near
        self._clear = clear

    def expects(self) -> Sequence[str]:
        return self._groups

    def process(self, samples: Sequence[Stamped[Signals]]) -> Iterable[Change]:
        graph, robot = self.knowledge.graph, self.knowledge.agent
        sample = samples[-1]
        for group in self._groups:
            if group not in sample.value:
                continue
            distance = min(sample.value[group])
            node = f"something {group}"
            known = graph.has(node)
            if not known and distance < self._near:
                graph.add(node, "object", distance=distance)
                graph.relate(robot, "near", node)
                yield self.change(sample.t, "obstacle", node, distance=distance)
            elif known and distance > self._clear:
                graph.remove(node)
                yield self.change(sample.t, "clear", node, distance=distance)
