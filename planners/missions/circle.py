"""Circle an object once while looking at it, for example to inspect it from all sides.

The robot drives to a point of the circle and then anticlockwise around the object. It faces the object all the time, so
it must be able to move sideways. After a reflex, it continues from the nearest point of its half of the circle.
"""

from math import cos, pi, sin

from py_trees.behaviour import Behaviour
from py_trees.composites import Sequence

from rocs_bt import InputError, PositiveMetres, PositiveMetresPerSecond, Radians
from rocs_bt.base.errors import unknown
from rocs_bt.plan import Mission

CORNERS = 12
"""Segments of half a circle; FollowPath rounds their corners to the circle."""


def build(
    mission: Mission,
    *,
    object: str,
    radius: PositiveMetres = 1.0,
    cruise: PositiveMetresPerSecond = 0.4,
    start: Radians = pi,
) -> Behaviour:
    """Build a sequence of three FollowPath leaves: to the circle, and along its two halves.

    Args:
        mission: Context of the mission.
        object: Node of the world model; the circle is around its position at the start of the mission.
        radius: Radius of the circle [m].
        cruise: Speed [m/s].
        start: Direction from the object to the first point of the circle, world frame [rad].

    Raises:
        InputError: The position of the object is unknown.
    """
    world = mission.knowledge.world
    centre = world.pose_of(object)
    if centre is None:
        known = [name for name in (*world.objects(), *world.places()) if world.pose_of(name) is not None]
        raise InputError(unknown("object with a known position", object, known))

    def point(angle: float, distance: float = radius) -> tuple[float, float]:
        return centre.x + distance * cos(angle), centre.y + distance * sin(angle)

    def half(first: float) -> list[tuple[float, float]]:
        return [point(first + pi * i / CORNERS) for i in range(CORNERS + 1)]

    paths = {
        "to the circle": [point(start, 1.2 * radius), point(start)],
        "first half": half(start),
        "second half": half(start + pi),
    }
    legs = [
        mission.act(
            "FollowPath", name=name, points=points, cruise=cruise, corner_radius=radius, heading=f"look_at {object}"
        )
        for name, points in paths.items()
    ]
    return Sequence(f"circle {object}", memory=True, children=legs)
