"""The tables `[[ground]]` and `[[push]]` of a scenario."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Annotated, Literal

from ..base.toml_table import Table
from ..base.units import ANGLE, FORCE, LENGTH, TIME, Bounds
from ..declare import Keys, Names, Scope, Valid, Value, Wrong
from .marks import At, Name, Pose

MOST_CELLS = 250_000
"""Maximum number of bumps of one rough ground."""

_SHORTEST = 0.01  # [m] minimum length and width of a ground, and minimum length of a step
_HIGHEST = 10.0  # [m] maximum height of a ground over the floor
_SIDE = Annotated[float, LENGTH, Bounds(_SHORTEST, 1e3)]
_FORCE = Annotated[float, FORCE, Bounds(-1e5, 1e5)]


def _without_slash(name: str) -> bool:
    return "/" not in name


_WHOLE = Valid(_without_slash, "a valid name of a ground: it contains '/'", "Use another character.")


class GroundSpec(Value):
    """One `[[ground]]` table: a rectangle of the floor that is not level. Only its side faces are obstacles.

    Attributes:
        name: Name without `/`, which also seeds the bumps of rough ground.
        kind: Random bumps, a plane that rises along its length, or one or more steps that rise along it.
        pose: Centre of the rectangle, world frame; the length is along its x axis.
        length, width: Size of the rectangle [m].
        height: Height of the highest bump, of the end of the slope, or of each step [m].
        grain: Distance of neighbouring bumps [m].
        count: Number of steps.
    """

    name: Annotated[Name, _WHOLE]
    kind: Literal["rough", "slope", "step"]
    pose: Pose
    length: _SIDE
    width: _SIDE
    height: Annotated[float, LENGTH, Bounds(1e-4, _HIGHEST)]
    grain: Annotated[float, LENGTH, Bounds(0.005, 100.0)] = 0.1
    count: Annotated[int, Bounds(1, 100)] = 1

    @classmethod
    def _prepare(cls, table: Table, scope: Scope) -> None:
        """Note the faults of keys of another kind."""
        kind = table.data.get("kind")
        for key, owner in (("grain", "rough"), ("count", "step")):
            if key in table and isinstance(kind, str) and kind != owner:
                table.fault(key, f"a ground of the kind '{kind}' has no '{key}'.", f"Only the kind '{owner}' has.")

    def _check(self) -> Iterator[Wrong]:
        """Faults of sizes that do not fit each other."""
        cells, step, rise = self.length * self.width / self.grain**2, self.length / self.count, self.height * self.count
        if self.kind == "rough" and cells > MOST_CELLS:
            yield Wrong(
                "grain", f"the ground has {cells:.0f} bumps; the maximum is {MOST_CELLS}.", "Use a coarser grain."
            )
        if step < _SHORTEST:
            message = f"the steps are {1e3 * step:.3g} mm long; the minimum is {1e3 * _SHORTEST:g} mm."
            yield Wrong("count", message, "Use fewer steps or a greater length.")
        if rise > _HIGHEST * (1.0 + 1e-9):
            message = f"the steps rise to {rise:.3g} m; the maximum is {_HIGHEST:g} m."
            yield Wrong("count", message, "Use fewer or lower steps.")


class ForceKeys(Value):
    """Keys of a force.

    Attributes:
        forward, left, up: Its parts, horizontal frame of the base [N].
    """

    forward: _FORCE = 0.0
    left: _FORCE = 0.0
    up: _FORCE = 0.0

    def _made(self) -> tuple[float, float, float]:
        """The force."""
        return self.forward, self.left, self.up


class PushSpec(Value):
    """One `[[push]]` table: a force on a robot's base for a short time.

    Attributes:
        robot: Name of the agent or actor.
        at: Time of the push, or earliest time [s].
        until: Latest time of the push [s]; the time is sampled uniformly with the seed. None for `at`.
        force: Force [N] forward, to the left and up, horizontal frame of the base.
        duration: Duration of the push [s].
        spread: Largest angle to either side by which the force is turned about the vertical [rad]; the angle is
            sampled uniformly with the seed.
    """

    robot: Annotated[str, Names("robot", "no agent or robot")]
    at: At
    until: At | None = None
    force: Annotated[tuple[float, float, float], Keys(ForceKeys)]
    duration: Annotated[float, TIME, Bounds(1e-3, 60.0)] = 0.1
    spread: Annotated[float, ANGLE, Bounds(0.0, math.pi)] = 0.0

    @property
    def latest(self) -> float:
        """Latest time of the push [s]."""
        return self.at if self.until is None else self.until

    def _check(self) -> Iterator[Wrong]:
        """Faults of times that do not fit each other, and of a force that is none."""
        if self.latest < self.at:
            message = f"the latest time of the push, {self.latest:g} s, is before its earliest, {self.at:g} s."
            yield Wrong("until", message)
        if not any(self.force):
            yield Wrong("force", "the push has no force.", 'Write force = { left = "60 N" }.')
