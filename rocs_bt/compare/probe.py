"""Probe: a sink that looks at how an agent moves, for the metrics that a run's summary does not hold."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from ..drivers.mujoco import MujocoWorld
from ..event import BodyMoved, Event, unpack
from ..simulation import SimulatedWorld

STEP = 0.05
"""How much of its way lies between two looks at the clearance, and two positions of the way [m]."""

TRACK = 0.1
"""How much of its way lies between two positions that are kept for pictures [m]."""


class Probe:
    """Watches one agent of a run in lockstep.

    Args:
        agent: Its name.

    Attributes:
        clearances: How near its hull was to anything but the floor, at each STEP of its way [m].
        energy: What it spent on gathering speed [J/kg]; None for a robot whose wheels nobody measures.
    """

    def __init__(self, agent: str) -> None:
        self.agent = agent
        self.clearances: list[float] = []
        self.energy: float | None = None
        self._world: MujocoWorld | None = None
        self._points: list[tuple[float, float]] = []
        self._driven = 0.0
        self._next = 0.0
        self._kinetic: float | None = None

    def prepare(self, stage: SimulatedWorld) -> None:
        """Take note of the world; for `run`'s argument of that name."""
        self._world = stage.world

    def emit(self, event: Event) -> None:
        """Look, where the event says that the agent was moved."""
        if not isinstance(event, BodyMoved) or event.agent != self.agent:
            return
        if self._points:
            self._driven += math.dist(self._points[-1], (event.x, event.y))
        self._points.append((event.x, event.y))
        if self._world is not None and self._driven >= self._next:
            self.clearances.append(self._world.clearance(self.agent)[0])
            self._next = self._driven + STEP
        if event.wheels:
            self._weigh(unpack(event.wheels))

    def way(self, step: float = STEP) -> npt.NDArray[np.float64]:
        """(n, 2) Where it was, at equal steps of its way [m]: the same way gives the same, however it was sampled."""
        points = np.array(self._points, dtype=float).reshape(-1, 2)
        if len(points) < 2:
            return points
        along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
        at = np.arange(0.0, along[-1], step)
        return np.column_stack([np.interp(at, along, points[:, axis]) for axis in (0, 1)])

    def track(self) -> bytes:
        """Where it was about every TRACK of its way, and at the end: (n, 2) float32 as bytes."""
        return np.vstack([self.way(TRACK), *self._points[-1:]]).astype(np.float32).tobytes()

    def _weigh(self, rims: list[float]) -> None:
        """Add what the drive's speed gained since the last look: half the mean square of its rims' speeds."""
        kinetic = sum(v * v for v in rims) / (2.0 * len(rims))
        self.energy = (self.energy or 0.0) + max(kinetic - (kinetic if self._kinetic is None else self._kinetic), 0.0)
        self._kinetic = kinetic
