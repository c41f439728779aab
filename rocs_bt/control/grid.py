"""Rows of numbers on an even grid, linear in between: look-ups without a search."""

from __future__ import annotations

import numpy as np

from .drive import Array


class Grid:
    """A function of one variable, sampled from 0 on at even steps, and held beyond both ends.

    Args:
        rows: (n, c) Values at 0, spacing, 2 spacing and so on.
        spacing: The step; 0 for a function that is the same everywhere.
    """

    def __init__(self, rows: Array, spacing: float) -> None:
        self._rows = np.ascontiguousarray(rows, dtype=float)
        # One more row of no change, so that the last sample needs no case of its own.
        self._slopes = np.vstack([np.diff(rows, axis=0), np.zeros((1, rows.shape[1]))])
        self._last = len(rows) - 1
        self._per_unit = 1.0 / spacing if spacing > 0.0 else 0.0

    def at(self, places: Array) -> Array:
        """(k, c) Rows at places (k,)."""
        steps = np.minimum(np.maximum(places * self._per_unit, 0.0), self._last)
        cell = steps.astype(np.intp)
        rows: Array = self._rows.take(cell, axis=0) + (steps - cell)[:, None] * self._slopes.take(cell, axis=0)
        return rows

    def look(self, place: float) -> list[float]:
        """(c,) The row at one place, as plain numbers."""
        step = min(max(place * self._per_unit, 0.0), self._last)
        cell = int(step)
        part = step - cell
        slopes = self._slopes[cell].tolist()
        return [low + part * slope for low, slope in zip(self._rows[cell].tolist(), slopes, strict=True)]
