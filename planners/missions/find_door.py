"""Fly to the doors one after the other until one is open, then return and land; for robots that observe doors.

The robot hovers before each door and turns from side to side, so that its beams sweep the whole width. What it observes
is in its Knowledge, which it may share with other robots. The mission fails after the landing if no door is open. It
needs a robot that flies and moves sideways.
"""

from math import degrees, radians

from py_trees.behaviour import Behaviour
from py_trees.behaviours import Success
from py_trees.composites import Selector, Sequence

from rocs_bt import Pose2, PositiveMetres, PositiveMetresPerSecond, PositiveSeconds
from rocs_bt.plan import Mission

LOW = 0.3
"""Height of the base above which the descent to the ground begins [m]."""

CLIMB = 0.3
"""Speed of take-off and landing [m/s]."""

SWEEP = radians(15.0)
"""Angle to either side of the direction of a door, between which the beams sweep its whole width [rad]."""


def build(
    mission: Mission,
    *,
    home: str = "pad",
    distance: PositiveMetres = 1.2,
    height: PositiveMetres = 0.7,
    cruise: PositiveMetresPerSecond = 0.5,
    patience: PositiveSeconds = 3.0,
) -> Behaviour:
    """Build a sequence: look at the doors in the order of their names, return to the place `home`, and land.

    Args:
        mission: Context of the mission.
        home: Place to land at.
        distance: Distance before a door at which the robot looks through it [m].
        height: Height of the flight [m].
        cruise: Speed [m/s].
        patience: Time for which the robot looks at a door that it cannot observe [s].

    """
    world = mission.knowledge.world
    doors = {name: pose for name in mission.knowledge.graph.nodes("door") if (pose := world.pose_of(name)) is not None}

    def look(door: str) -> Behaviour:
        view = doors[door].compose(Pose2(-distance, 0.0, 0.0))
        there = [(view.x, view.y)] * 2

        def face(side: str, angle: float) -> Behaviour:
            yaw = f"{degrees(view.yaw + angle):.6g} deg"
            return mission.act(
                "FollowPath", name=f"{side} side of {door}", points=there, cruise=cruise, heading=yaw, height=height
            )

        return Sequence(
            f"look at {door}",
            memory=True,
            children=[
                mission.act("FollowPath", name=f"to {door}", points=there, cruise=cruise, height=height),
                face("left", SWEEP),
                face("right", -SWEEP),
                mission.node("WaitForOpenDoor", name=f"{door} is open", door=door, patience=patience),
            ],
        )

    return Sequence(
        "find an open door",
        memory=True,
        children=[
            mission.node("Ask", name="a door is known", query="door where known(pose)"),
            mission.act("SetTwist", name="take off", up=CLIMB, duration=height / CLIMB),
            Selector("look at the doors", memory=True, children=[*map(look, sorted(doors)), Success("all doors seen")]),
            mission.act("GoTo", name="return", goal=home, cruise=cruise),
            mission.act("GoTo", name="descend", goal=home, cruise=cruise, height=LOW),
            mission.act("SetTwist", name="land", up=-CLIMB, duration=LOW / CLIMB + 1.5),
            mission.node("WaitForOpenDoor", name="a door is open", patience=0.0),
        ],
    )
