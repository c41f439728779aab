"""Inspect an object by flying around it at two heights while looking at it, then land at the start of the flight.

The robot takes off, flies to a point of the circle, circles the object anticlockwise at the first height and again at
the second, and returns to the place `home`. It must be able to fly and to move sideways. After a reflex, it continues
from the nearest point of its half of the circle; a half in which it has missed a point is flown again.
"""

from math import cos, dist, nan, pi, sin

from py_trees.behaviour import Behaviour
from py_trees.composites import Selector, Sequence

from rocs_bt import InputError, PositiveMetres, PositiveMetresPerSecond, Radians
from rocs_bt.base.errors import unknown
from rocs_bt.plan import Mission, mission_of
from rocs_bt.trees.nodes import FAILURE, RUNNING, SUCCESS, Decorator, Outcome

CORNERS = 12
"""Segments of half a circle; FollowPath rounds their corners to the circle."""

LOW = 0.3
"""Height of the base above which the descent to the ground begins [m]."""

DESCENT = 0.3
"""Speed of the descent to the ground [m/s]."""

PASSED = 0.3
"""Distance within which a point of a circle counts as passed [m]."""

ATTEMPTS = 4
"""How often each half of a circle is flown at most; afterwards the mission goes on, to bring the robot home."""


class Passes(Decorator):
    """Ticks its child, a flight, and fails if the flight succeeds without having passed all points.

    Args:
        name: Name in displays.
        child: The flight.
        points: Points to pass, world frame: x, y, z [m].
    """

    def __init__(self, name: str, child: Behaviour, points: list[tuple[float, float, float]]) -> None:
        super().__init__(name, child)
        self._points = points
        self._missed = set(points)

    def tick_once(self) -> Outcome:
        if self.status is not RUNNING:
            self._missed = set(self._points)
        knowledge, now = mission_of(self).knowledge, mission_of(self).clock.now()
        pose, signals = knowledge.robot.pose(now), knowledge.signals
        position = pose.x, pose.y, signals.value("height", now) if "height" in signals else nan
        self._missed = {point for point in self._missed if not dist(point, position) <= PASSED}
        outcome = self.tick_child()
        if outcome is SUCCESS and self._missed:
            self.feedback_message = f"{len(self._missed)} of {len(self._points)} points were not passed"
            outcome = FAILURE
        self.status = outcome
        return outcome


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
    """Build a sequence: to the circle, two halves of it at both heights, back to the place `home`, and down.

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

    def inspected(name: str, begin: float, height: float) -> Behaviour:
        """Fly along half a circle; if it has missed points, fly back and try again."""

        def attempt(number: int) -> Behaviour:
            flight = leg(f"{name}, attempt {number}", half(begin), height)
            if number < ATTEMPTS:
                flight = Passes(f"{name}, all points", flight, [(x, y, height) for x, y in half(begin)])
            if number == 1:
                return flight
            back = leg(f"{name}, back {number}", half(begin)[::-1], height)
            return Sequence(f"{name} again", memory=True, children=[back, flight])

        return Selector(name, memory=True, children=[attempt(number + 1) for number in range(ATTEMPTS)])

    begin = half(start)[0]
    away = centre.x + 1.2 * (begin[0] - centre.x), centre.y + 1.2 * (begin[1] - centre.y)
    legs = [leg("to the circle", [away, begin], first)]
    for name, height in (("first", first), ("second", second)):
        legs += [
            leg(f"{name} height", [begin, begin], height),
            inspected(f"{name} circle, first half", start, height),
            inspected(f"{name} circle, second half", start + pi, height),
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
