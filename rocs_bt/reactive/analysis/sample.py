"""Vectorised evaluation of expressions on many snapshots, to find examples quickly.

Temporal operators are evaluated as if each snapshot had been constant for ever: `held(a)` and `once(a)` are a, and a
rate is 0. This is an approximation, so the evaluator confirms each example before it is reported.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ...expression import Node

Array: TypeAlias = NDArray[np.float64]
Range: TypeAlias = tuple[float, float]


class Samples:
    """Sampled snapshots, on which expressions are evaluated; values are cached.

    Args:
        rows: P snapshots, shape (P, size).
    """

    def __init__(self, rows: Array) -> None:
        self.rows = rows
        self._memo: dict[Node, Array] = {}

    def truth(self, node: Node) -> NDArray[np.bool_]:
        """Whether a scalar boolean expression is true on each snapshot, shape (P,)."""
        found: NDArray[np.bool_] = np.broadcast_to(self.value(node) == 1.0, len(self.rows))
        return found

    def value(self, node: Node) -> Array:
        """Values of an expression on all snapshots; truth values are 1, 0, or NaN if invalid.

        Returns:
            Array of shape (P,), or (P, n) for a group of n values, or broadcastable to it.
        """
        if node not in self._memo:
            with np.errstate(all="ignore"):
                self._memo[node] = self._computed(node)
        return self._memo[node]

    def _computed(self, node: Node) -> Array:
        if node.op in ("number", "truth"):
            return np.full(len(self.rows), float(node.value))
        if node.op == "vector":
            return np.array([[float(arg.value) for arg in node.args]])
        if node.op == "read":
            return self.rows[:, node.start : node.stop] if node.kind.size else self.rows[:, node.start]
        values = [self.value(arg) for arg in node.args]
        if node.op in _REDUCTIONS:
            groups = [v if v.ndim == 2 else v[:, None] for v in values]
            return _REDUCTIONS[node.op](*groups)
        if node.kind.size:
            values = [v if v.ndim == 2 else v[:, None] for v in values]
        if node.op == "compare":
            return _worst([_compared(sign, a, b) for sign, a, b in zip(node.signs, values, values[1:], strict=False)])
        return _SINGLE[node.op](*values)


def _compared(sign: str, a: Array, b: Array) -> Array:
    found: Array = np.where(np.isnan(a) | np.isnan(b), np.nan, _SIGNS[sign](a, b))
    return found


def _worst(truths: list[Array]) -> Array:
    """Conjunction in three-valued logic: 0 if any value is 0, else NaN (invalid) if any is NaN, else 1."""
    stacked = np.broadcast_arrays(*truths)
    return np.asarray(np.where(np.any([t == 0.0 for t in stacked], axis=0), 0.0, np.sum(stacked, axis=0) * 0.0 + 1.0))


def _best(truths: list[Array]) -> Array:
    return 1.0 - _worst([1.0 - t for t in truths])


def _columns(group: Array) -> list[Array]:
    return [group[:, i] for i in range(group.shape[1])]


def _stacked(*groups: Array) -> Array:
    rows = max(len(g) for g in groups)
    return np.concatenate([np.broadcast_to(g, (rows, g.shape[1])) for g in groups], axis=1)


def _least_valid(group: Array, least: Array) -> Array:
    valid = ~np.isnan(group)
    return np.where(valid.sum(axis=1) >= least[:, 0], np.where(valid, group, np.inf).min(axis=1), np.nan)


_SIGNS: Mapping[str, Callable[[Any, Any], Any]] = {
    "<": np.less, "<=": np.less_equal, ">": np.greater, ">=": np.greater_equal, "==": np.equal, "!=": np.not_equal,
}  # fmt: skip  # a table
_REDUCTIONS: Mapping[str, Callable[..., Array]] = {
    "min": lambda *g: _stacked(*g).min(axis=1),
    "max": lambda *g: _stacked(*g).max(axis=1),
    "sum": lambda g: g.sum(axis=1),
    "mean": lambda g: g.mean(axis=1),
    "argmin": lambda g: np.where(np.isnan(g).any(axis=1), np.nan, g.argmin(axis=1)),
    "count": lambda g: g.sum(axis=1),
    "any": lambda g: _best(_columns(g)),
    "all": lambda g: _worst(_columns(g)),
    "min_valid": _least_valid,
    "dot": lambda g, v: (g * v).sum(axis=1),
}
_SINGLE: Mapping[str, Callable[..., Array]] = {
    "neg": lambda a: -a,
    "not": lambda a: 1.0 - a,
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "/": lambda a, b: np.where(b == 0.0, np.nan, a / b),
    "and": lambda *t: _worst(list(t)),
    "or": lambda *t: _best(list(t)),
    "if": lambda c, a, b: np.where(np.isnan(c), np.nan, np.where(c == 1.0, a, b)),
    "abs": np.abs,
    "clip": lambda a, low, high: np.minimum(np.maximum(a, low), high),
    "hypot": np.hypot,
    "atan2": np.arctan2,
    "sign": np.sign,
    "side": lambda a: np.where(np.isnan(a), np.nan, np.where(a >= 0.0, 1.0, -1.0)),
    "sqrt": np.sqrt,
    "wrap_angle": lambda a: np.pi - np.mod(np.pi - a, 2.0 * np.pi),
    "held": lambda a: a,
    "once": lambda a: a,
    "delay": lambda a: a,
    "since": lambda a, b: b,
    "time_since": lambda a: np.where(np.isnan(a), np.nan, np.where(a == 1.0, 0.0, np.inf)),
    "rate": lambda a: a * 0.0,
}


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
