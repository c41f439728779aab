"""The standard schema: what may stand in the knowledge graph, as data.

A project adds to it in code:

    schema = SCHEMA.extended(
        kinds=[Kind("charger", {"pose": Attribute(Pose2, POSE), "power": Attribute(float, (FORCE * SPEED,))})],
        relations=[Relation("docks_at", ("robot",), ("charger",), single=True)],
    )
"""

from __future__ import annotations

from ..geometry import Pose2
from ..units import ACCELERATION, ANGLE, FREQUENCY, LENGTH, MASS, SPEED, TIME, TURN_RATE
from .attribute import Attribute, Live
from .declaration import Kind, Relation, Schema

POSE = (LENGTH, LENGTH, ANGLE)


def _length(doc: str = "", required: bool = False) -> Attribute:
    return Attribute(float, (LENGTH,), required, low=0.0, doc=doc)


def _text(doc: str = "", required: bool = False) -> Attribute:
    return Attribute(str, required=required, doc=doc)


def _pose(doc: str, required: bool = True) -> Attribute:
    return Attribute(Pose2, POSE, required, doc=f"{doc}, in the world frame")


def _tolerance(doc: str) -> Attribute:
    # The stop distance of the published experiments (paper, 6).
    return Attribute(float, (LENGTH,), low=0.0, default=0.1, doc=doc)


_OUTLINE = {
    "radius": _length("of the hull seen from above"),
    "length": _length("along its own x"),
    "width": _length("along its own y"),
    "height": _length("above the floor"),
}
_SEEN = ("robot", "object", "peer", "place", "goal")

SCHEMA = Schema.of(
    kinds=(
        Kind(
            "robot",
            {
                **_OUTLINE,
                "model": _text("the robot's folder"),
                "drive": _text("the kind of drive"),
                "mode": _text("what it is about, as its mission says; rules may live in some modes alone"),
                "mass": Attribute(float, (MASS,), low=0.0),
                "track": _length("between the wheels, effective"),
                "wheel_radius": _length(),
                "speed_limit": Attribute(float, (SPEED,), low=0.0, doc="of the centre, straight on"),
                "turn_limit": Attribute(float, (TURN_RATE,), low=0.0, doc="on the spot"),
                "wheel_speed_limit": Attribute(float, (SPEED,), low=0.0, doc="of a rim"),
                "wheel_acceleration_limit": Attribute(float, (ACCELERATION,), low=0.0, doc="of a rim"),
            },
            doc="A robot whose mind this is",
        ),
        Kind(
            "sensor",
            {
                "driver": _text("which driver reads it"),
                "signal": _text("the signal that holds its newest values"),
                "values": Attribute(Live, doc="the newest values, live and read-only, SI units"),
                "monitor": _text("the Monitor that interprets it"),
                "rate": Attribute(float, (FREQUENCY,), low=0.0, doc="samples per second"),
                "size": Attribute(int, low=1, doc="values in a sample"),
                "range_low": _length("shortest range it tells"),
                "range_high": _length("longest range it tells"),
            },
            doc="A sensing device",
        ),
        Kind(
            "actuator",
            {
                "driver": _text("which driver commands it"),
                "size": Attribute(int, low=1, doc="values in a command"),
                "max_command_age": Attribute(float, (TIME,), low=0.0, doc="longest silence"),
            },
            doc="An acting device",
        ),
        Kind("monitor", {"class_name": _text()}, doc="A Monitor block"),
        Kind("analyze", {"class_name": _text()}, doc="An Analyze block"),
        Kind(
            "object",
            {
                "pose": _pose("where it is", required=False),
                **_OUTLINE,
                "distance": _length("from the robot, as a sensor tells it"),
                "bearing": Attribute(float, (ANGLE,), doc="from the robot's heading, left positive"),
                "moves": Attribute(bool, doc="whether it may move"),
            },
            doc="A thing in the world, perhaps felt only, its pose not known",
        ),
        Kind("place", {"pose": _pose("where it is"), "tolerance": _tolerance("how near counts as there")}),
        Kind("goal", {"pose": _pose("where it is"), "tolerance": _tolerance("how near counts as reached")}),
        Kind(
            "peer",
            {
                "pose": _pose("where it is, as far as is known; none before it is seen and once it is given up", False),
                **_OUTLINE,
                "tag": Attribute(int, low=1, doc="by which a robot sensor knows it"),
                "speed": Attribute(float, (SPEED,), doc="forward"),
                "turn_rate": Attribute(float, (TURN_RATE,), doc="left positive"),
                "spread": _length("standard deviation of where it is"),
            },
            doc="Another robot",
        ),
        Kind("strategy", {"mission": _text("the mission that carries it out"), "doc": _text()}, doc="A way to act"),
        Kind("rule_set", {"file": _text(), "rules": Attribute(int, low=0)}, doc="A file of reflex rules"),
    ),
    relations=(
        Relation("has_sensor", ("robot", "peer"), ("sensor",)),
        Relation("has_actuator", ("robot", "peer"), ("actuator",)),
        Relation("reads", ("monitor",), ("sensor",)),
        Relation("listens_to", ("analyze",), ("monitor",)),
        Relation("at", ("robot", "peer", "object"), ("place", "goal")),
        Relation("near", _SEEN, _SEEN, {"distance": _length("between the two")}),
        Relation("sees", ("robot", "peer"), ("object", "peer", "robot")),
        Relation("connects", ("place", "goal"), ("place", "goal"), {"length": _length("of the way")}),
        Relation("pursues", ("robot", "peer"), ("goal",), single=True),
        Relation(
            "follows",
            ("robot", "peer"),
            ("robot", "peer"),
            {"distance": _length("to keep"), "safety": _length("nearer than which it must not drive")},
            single=True,
        ),
        Relation("uses", ("robot",), ("strategy",), single=True, doc="the strategy in force"),
        Relation("falls_back_to", ("strategy",), ("strategy",), single=True),
        Relation("guarded_by", ("robot", "strategy"), ("rule_set",)),
    ),
)
