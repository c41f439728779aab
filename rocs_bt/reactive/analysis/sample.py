"""Sampled snapshots, on which examples are found quickly."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ...expression import TRUTH, Node, Steady
from ...expression.operators import ROWS

Array: TypeAlias = NDArray[np.float64]
Range: TypeAlias = tuple[float, float]


class Samples:
    """Snapshots, on which expressions are evaluated; values are cached.

    Args:
        rows: P snapshots, shape (P, size).
        nodes: Expressions of which all tests are evaluated at once.
    """

    def __init__(self, rows: Array, nodes: Sequence[Node] = ()) -> None:
        self.rows = rows
        tests = [*dict.fromkeys(part for node in nodes for part in node.walk() if part.kind == TRUTH)]
        self._known = dict(zip(tests, Steady(tests)(rows), strict=True))

    def truth(self, node: Node) -> NDArray[np.bool_]:
        """Whether a scalar boolean expression is true on each snapshot, shape (P,)."""
        found: NDArray[np.bool_] = self._value(node) == 1.0
        return found

    def _value(self, node: Node) -> Array:
        """Value on all snapshots: 1, 0, or NaN if invalid, shape (P,)."""
        if node not in self._known:
            function = ROWS[node.op].numpy if node.op in ("and", "or", "not") else None
            if function is None:
                (self._known[node],) = Steady([node])(self.rows)
            else:
                first, *others = (self._value(arg) for arg in node.args)
                found = function(first) if node.op == "not" else first
                for other in others:
                    found = function(found, other)
                self._known[node] = found
        return self._known[node]


def sample_rows(nodes: Iterable[Node], bounds: list[Range], count: int) -> Array:
    """Sample snapshots with many values near the constants of expressions; deterministic.

    Returns:
        Snapshots, shape (count, size).
    """
    marks = sorted({float(n.value) for node in nodes for n in node.walk() if n.op == "number"})
    near = np.array([m + step for m in marks for step in (-0.01, 0.0, 0.01)] or [0.0])
    near = near[np.isfinite(near)]
    near = near if near.size else np.zeros(1)
    random = np.random.default_rng(0)
    low, high = np.array([b for b, _ in bounds]), np.array([b for _, b in bounds])
    soft_low = np.where(np.isfinite(low), low, np.minimum(high - 10.0, -10.0))
    soft_high = np.where(np.isfinite(high), high, np.maximum(soft_low + 10.0, 10.0))
    rows = random.uniform(soft_low, soft_high, (count, len(bounds)))
    picked = random.choice(near, (count, len(bounds)))
    chosen = random.random((count, len(bounds))) < random.choice([0.1, 0.5, 1.0], (count, 1))
    rows = np.where(chosen, picked, rows)
    # The minimum of a group is high only if all its values are.
    level = np.where(random.random((count, 1)) < 0.5, random.choice(near, (count, 1)), np.inf)
    rows = np.where((random.random((count, 1)) < 0.4) & np.isfinite(level), np.maximum(rows, level), rows)
    # Guards compare groups with each other: on some snapshots all values of a group are equal.
    groups = sorted({(n.start, n.stop) for node in nodes for n in node.walk() if n.op == "read" and n.kind.size})
    for start, stop in groups:
        one = random.random((count, 1)) < random.choice([0.0, 0.5, 0.9], (count, 1))
        value = np.where(random.random((count, 1)) < 0.5, random.choice(near, (count, 1)), rows[:, start : start + 1])
        rows[:, start:stop] = np.where(one, value, rows[:, start:stop])
    with np.errstate(over="ignore"):  # the largest numbers round to inf, which is clipped
        rows = np.clip(np.round(rows, 2), soft_low, soft_high)
    # Only the last snapshots have infinite values, because earlier ones are preferred as examples.
    far = random.random((count // 20, len(bounds))) < random.choice([0.3, 1.0], (count // 20, 1))
    rows[-(count // 20) :] = np.where(far & ~np.isfinite(high), high, rows[-(count // 20) :])
    return np.asarray(rows)
