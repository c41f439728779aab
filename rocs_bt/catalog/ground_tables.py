"""The tables `[[ground]]` and `[[push]]` of a scenario."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from ..base.errors import did_you_mean
from ..base.geometry import Pose2, wrap_angle
from ..base.toml_table import Table
from ..base.units import ANGLE, FORCE, LENGTH, TIME
from .values import read_name

GROUND_KINDS = ("rough", "slope", "step")
"""Kinds of ground: random bumps, a plane that rises along its length, and one or more steps that rise along it."""

MOST_CELLS = 250_000
"""Maximum number of bumps of one rough ground."""

MOST_STEPS = 100
"""Maximum number of steps of one ground."""

_SHORTEST = 0.01  # [m] minimum length and width of a ground, and minimum length of a step
_HIGHEST = 10.0  # [m] maximum height of a ground over the floor


@dataclass(frozen=True)
class GroundSpec:
    """One `[[ground]]` table: a rectangle of the floor that is not level. Only its side faces are obstacles.

    Attributes:
        name: Name without `/`, which also seeds the bumps of rough ground.
        kind: One of `GROUND_KINDS`.
        pose: Centre of the rectangle, world frame; the length is along its x axis.
        length, width: Size of the rectangle [m].
        height: Height of the highest bump, of the end of the slope, or of each step [m].
        grain: Distance of neighbouring bumps [m].
        count: Number of steps.
        line: Line of the table in the file.
    """

    name: str
    kind: str
    pose: Pose2
    length: float
    width: float
    height: float
    grain: float = 0.1
    count: int = 1
    line: int = 0


@dataclass(frozen=True)
class PushSpec:
    """One `[[push]]` table: a force on a robot's base for a short time.

    Attributes:
        robot: Name of the agent or actor.
        force: Force [N] forward, to the left and up, horizontal frame of the base.
        at: Time of the push, or earliest time [s].
        until: Latest time of the push [s]; the time is sampled uniformly with the seed.
        duration: Duration of the push [s].
        spread: Largest angle to either side by which the force is turned about the vertical [rad]; the angle is
            sampled uniformly with the seed.
        line: Line of the table in the file.
    """

    robot: str
    force: tuple[float, float, float]
    at: float
    until: float
    duration: float
    spread: float = 0.0
    line: int = 0


def read_grounds(root: Table) -> tuple[GroundSpec, ...]:
    """Read the grounds of a scenario; faults are noted in their tables."""
    found: list[GroundSpec] = []
    for table in root.tables("ground"):
        ground = _ground(table)
        if ground.name in [other.name for other in found]:
            table.fault("name", f"another ground has the name '{ground.name}'.", "Give each ground its own.")
        found.append(ground)
    return tuple(found)


def _ground(table: Table) -> GroundSpec:
    kind = table.choice("kind", GROUND_KINDS)
    x, y = (table.quantity(key, LENGTH, low=-1e4, high=1e4) for key in ("x", "y"))
    length, width = (table.quantity(key, LENGTH, low=_SHORTEST, high=1e3) for key in ("length", "width"))
    height = table.quantity("height", LENGTH, low=1e-4, high=_HIGHEST)
    grain = table.quantity("grain", LENGTH, 0.1, low=0.005, high=100.0)
    if kind == "rough" and (cells := length * width / grain**2) > MOST_CELLS:
        table.fault("grain", f"the ground has {cells:.0f} bumps; the maximum is {MOST_CELLS}.", "Use a coarser grain.")
    for key, owner in (("grain", "rough"), ("count", "step")):
        if key in table and kind != owner:
            table.fault(key, f"a ground of the kind '{kind}' has no '{key}'.", f"Only the kind '{owner}' has.")
    count = table.integer("count", 1, low=1, high=MOST_STEPS)
    if length / count < _SHORTEST:
        each = f"the steps are {1e3 * length / count:.3g} mm long; the minimum is {1e3 * _SHORTEST:g} mm."
        table.fault("count", each, "Use fewer steps or a greater length.")
    if height * count > _HIGHEST * (1.0 + 1e-9):
        total = f"the steps rise to {height * count:.3g} m; the maximum is {_HIGHEST:g} m."
        table.fault("count", total, "Use fewer or lower steps.")
    name = read_name(table)
    if "/" in name:
        table.fault("name", f"'{name}' is not a valid name of a ground: it contains '/'.", "Use another character.")
    return GroundSpec(
        name=name,
        kind=kind,
        pose=Pose2(x, y, wrap_angle(table.quantity("yaw", ANGLE, 0.0, low=-1e4, high=1e4))),
        length=length,
        width=width,
        height=height,
        grain=grain,
        count=count,
        line=table.position()[0],
    )


def read_pushes(root: Table, robots: Sequence[str]) -> tuple[PushSpec, ...]:
    """Read the pushes of a scenario; faults are noted in their tables."""
    return tuple(_push(table, robots) for table in root.tables("push"))


def _push(table: Table, robots: Sequence[str]) -> PushSpec:
    robot = table.text("robot")
    if robot and robot not in robots:
        table.fault("robot", f"no agent or robot is named '{robot}'.", did_you_mean(robot, robots, "The scenario"))
    at = table.quantity("at", TIME, low=0.0, high=86400.0)
    until = table.quantity("until", TIME, at, low=0.0, high=86400.0)
    if until < at:
        table.fault("until", f"the latest time of the push, {until:g} s, is before its earliest, {at:g} s.")
    force = table.table("force", optional=False)
    forward, left, up = (force.quantity(key, FORCE, 0.0, low=-1e5, high=1e5) for key in ("forward", "left", "up"))
    if not any((forward, left, up)) and "force" in table:
        table.fault("force", "the push has no force.", 'Write force = { left = "60 N" }.')
    return PushSpec(
        robot=robot,
        force=(forward, left, up),
        at=at,
        until=until,
        duration=table.quantity("duration", TIME, 0.1, low=1e-3, high=60.0),
        spread=table.quantity("spread", ANGLE, 0.0, low=0.0, high=math.pi),
        line=table.position()[0],
    )
