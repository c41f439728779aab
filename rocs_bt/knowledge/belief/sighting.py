"""Sighting: one thing that one look showed."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


class Sighting(NamedTuple):
    """Where something was seen.

    Attributes:
        position: (2,) In the world frame [m].
        covariance: (2, 2) Of the position [m2].
        radius: How far it reaches around its position [m].
    """

    position: Array
    covariance: Array
    radius: float
