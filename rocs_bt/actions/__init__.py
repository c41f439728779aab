"""Shipped actions (paper, Table 2, and motion actions on top of these), and the table from name to class.

Code that builds agents or checks content imports this package. The blocks of an agent receive the table and refer to
actions by name. Only `reactive` imports an action itself: Stop, for a reflex with an action that cannot run.
"""

from .avoid_collision import AvoidCollision
from .dock import Dock
from .flinch import Flinch
from .follow_path import FollowPath
from .follow_robot import FollowRobot
from .follow_route import FollowRoute
from .go_to import GoTo
from .go_to_origin import GoToOrigin
from .send_message import SendMessage
from .set_twist import SetTwist
from .set_wheel_speed import SetWheelSpeed
from .stop import Stop
from .table import ACTIONS, action_table
from .turn import TurnAngle, TurnTo, TurnToOrigin, TurnToPosition

__all__ = [
    "ACTIONS",
    "AvoidCollision",
    "Dock",
    "Flinch",
    "FollowPath",
    "FollowRobot",
    "FollowRoute",
    "GoTo",
    "GoToOrigin",
    "SendMessage",
    "SetTwist",
    "SetWheelSpeed",
    "Stop",
    "TurnAngle",
    "TurnTo",
    "TurnToOrigin",
    "TurnToPosition",
    "action_table",
]
