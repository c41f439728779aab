"""RelayTwist: action that passes on the twists of another program, such as Nav2, through the agent's safety gate."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from ...base.geometry import Twist3
from ...interfaces.action import AtomicAction, Body, Failure, Progress
from ..ros_link import Received, RosSubscription

MAX_AGE = 0.5
"""Maximum age of a twist [s]; the body rests without a newer one, as with ros2_control."""

TWISTS = {"geometry_msgs/msg/Twist": (), "geometry_msgs/msg/TwistStamped": ("twist",)}
"""Path of the twist in each message type."""


@dataclass(kw_only=True, eq=False)
class RelayTwist(AtomicAction):
    """Commands the newest twist of a topic each period, until it is cancelled; rests while there is no recent one."""

    _topic: RosSubscription | None = field(default=None, init=False, repr=False)
    _type: str = field(default="", init=False, repr=False)

    @classmethod
    def of(cls, topic: RosSubscription, type: str) -> RelayTwist:
        """Create the action for a subscription, which only it reads, with messages of one of `TWISTS`."""
        made = cls()
        made._topic, made._type = topic, type
        return made

    def act(self, body: Body) -> Progress | Failure:
        newest = None if self._topic is None else self._topic.newest()
        twist = None if newest is None or newest.age > MAX_AGE else self._twist(newest)
        if twist is None:
            body.rest()
        else:
            body.move(twist)
        return Progress.RUNNING

    def _twist(self, received: Received) -> Twist3 | None:
        """Twist of a message; None if it is not finite."""
        values = received.message.get(TWISTS[self._type])
        linear, angular = values["linear"], values["angular"]
        numbers = (linear["x"], linear["y"], linear["z"], angular["z"])
        return Twist3(*map(float, numbers)) if all(map(math.isfinite, numbers)) else None
