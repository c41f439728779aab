"""Sparse graph of the cells of a grid and their eight neighbours, for the searches of SciPy."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from .locomotion import Array

if TYPE_CHECKING:
    from scipy.sparse import csr_array

NEIGHBOURS = ((-1, -1), (-1, 0), (-1, 1), (0, -1), (0, 1), (1, -1), (1, 0), (1, 1))
"""Rows and columns from a cell to its neighbours."""

LEGS = [math.hypot(*step) for step in NEIGHBOURS]


def grid_graph(cost: Array, guess: Array | None = None) -> csr_array:
    """Graph of all cells, row by row; an edge costs its length in cells times the mean cost of both cells.

    Args:
        cost: Cost of each cell, shape (rows, columns); +inf closes a cell.
        guess: Lower bound of the cost from each cell to the goal, shape (rows, columns). If given, edges are reduced by
            its decrease, so that Dijkstra's algorithm acts as A*.
    """
    from scipy.sparse import csr_array

    rows, columns = cost.shape
    near, starts = _neighbours(rows, columns)
    around = np.pad(cost, 1, constant_values=math.inf)
    weights = np.empty((rows, columns, len(NEIGHBOURS)))
    bound = np.zeros_like(cost) if guess is None else guess
    ahead = np.pad(bound, 1)
    for k, (i, j) in enumerate(NEIGHBOURS):
        part = slice(1 + i, 1 + i + rows), slice(1 + j, 1 + j + columns)
        weights[:, :, k] = (0.5 * LEGS[k]) * (cost + around[part]) + (ahead[part] - bound)
    np.maximum(weights, 1e-9, out=weights)  # rounding may give negative values; a zero would be no edge
    return csr_array((weights.reshape(-1), near, starts), shape=(cost.size, cost.size))


@lru_cache(maxsize=16)
def _neighbours(rows: int, columns: int) -> tuple[npt.NDArray[np.int32], npt.NDArray[np.int32]]:
    """Column indices and row starts of the sparse adjacency matrix of a grid's cells.

    A neighbour outside the grid is replaced by the cell itself, at infinite cost.
    """
    own = np.arange(rows * columns, dtype=np.int32).reshape(rows, columns)
    padded = np.pad(own, 1, constant_values=-1)
    near = np.stack([padded[1 + i : 1 + i + rows, 1 + j : 1 + j + columns] for i, j in NEIGHBOURS], axis=-1)
    near = np.where(near < 0, own[:, :, None], near)
    starts = np.arange(0, len(NEIGHBOURS) * own.size + 1, len(NEIGHBOURS), dtype=np.int32)
    return near.reshape(-1), starts
