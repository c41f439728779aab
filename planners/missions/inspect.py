"""Inspect an object by flying around it at two heights while looking at it, then land at the start of the flight.

The robot takes off, flies to a point of the circle, circles the object anticlockwise at the first height and again at
the second, and returns to the place `home`. It must be able to fly and to move sideways. After a reflex, it continues
from the nearest point of its half of the circle.
"""

from math import cos, pi, sin

from py_trees.behaviour import Behaviour
from py_trees.composites import Sequence

from rocs_bt.errors import InputError, unknown
from rocs_bt.plan import Mission
from rocs_bt.units import PositiveMetres, PositiveMetresPerSecond, Radians

CORNERS = 12
"""Segments of half a circle; FollowPath rounds their corners to the circle."""

LOW = 0.3
"""Height of the base above which the descent to the ground begins [m]."""

DESCENT = 0.3
"""Speed of the descent to the ground [m/s]."""


def build(
    mission: Mission,
    *,
    object: str,
    home: str = "pad",
    radius: PositiveMetres = 1.0,
    first: PositiveMetres = 0.8,
    second: PositiveMetres = 1.6,
    cruise: PositiveMetresPerSecond = 0.4,
    start: Radians = pi,
) -> Behaviour:
    """Build a sequence: to the circle, twice two halves of it, back to the place `home`, and down.

    Args:
        mission: Context of the mission.
        object: Node of the world model; the circles are around its position at the start of the mission.
        home: Place to land at.
        radius: Radius of the circles [m].
        first: Height of the first circle [m].
        second: Height of the second circle [m].
        cruise: Speed [m/s].
        start: Direction from the object to the first point of the circles, world frame [rad].

    Raises:
        InputError: The position of the object is unknown.
    """
    world = mission.knowledge.world
    centre = world.pose_of(object)
    if centre is None:
        known = [name for name in (*world.objects(), *world.places()) if world.pose_of(name) is not None]
        raise InputError(unknown("object with a known position", object, known))
    look_at = f"look_at {object}"

    def half(begin: float) -> list[tuple[float, float]]:
        angles = [begin + pi * i / CORNERS for i in range(CORNERS + 1)]
        return [(centre.x + radius * cos(angle), centre.y + radius * sin(angle)) for angle in angles]

    def leg(name: str, points: list[tuple[float, float]], height: float) -> Behaviour:
        return mission.act(
            "FollowPath",
            name=name,
            points=points,
            cruise=cruise,
            corner_radius=radius,
            heading=look_at,
            height=height,
        )

    begin = half(start)[0]
    away = centre.x + 1.2 * (begin[0] - centre.x), centre.y + 1.2 * (begin[1] - centre.y)
    legs = [leg("to the circle", [away, begin], first)]
    for name, height in (("first", first), ("second", second)):
        legs += [
            leg(f"{name} height", [begin, begin], height),
            leg(f"{name} circle, first half", half(start), height),
            leg(f"{name} circle, second half", half(start + pi), height),
        ]
    return Sequence(
        f"inspect {object}",
        memory=True,
        children=[
            *legs,
            mission.act("GoTo", name="return", goal=home, cruise=cruise, heading=look_at, height=second),
            mission.act("GoTo", name="descend", goal=home, cruise=cruise, heading=look_at, height=LOW),
            mission.act("SetTwist", name="land", up=-DESCENT, duration=LOW / DESCENT + 1.5),
        ],
    )
