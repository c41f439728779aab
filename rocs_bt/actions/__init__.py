"""Shipped actions (paper, Table 2, and motion actions on top of these), and the table from name to class.

Code that builds agents or checks content imports this package. The blocks of an agent receive the table and refer to
actions by name. Only `reactive` imports an action itself: Stop, for a reflex with an action that cannot run.
"""

from collections.abc import Mapping
from types import MappingProxyType

from ..base.errors import Fault, InputError
from ..interfaces.action import Action
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

_SHIPPED: tuple[type[Action], ...] = (
    AvoidCollision,
    Dock,
    Flinch,
    FollowPath,
    FollowRobot,
    FollowRoute,
    GoTo,
    GoToOrigin,
    SendMessage,
    SetTwist,
    SetWheelSpeed,
    Stop,
    TurnAngle,
    TurnTo,
    TurnToOrigin,
    TurnToPosition,
)


def action_table(*more: type[Action]) -> Mapping[str, type[Action]]:
    """Create an action table from the shipped actions and a user's own, keyed by class name.

    Args:
        more: Additional action classes (paper, 5.3: a mandatory extension point).

    Raises:
        InputError: Two different classes have the same name.
    """
    table: dict[str, type[Action]] = {}
    for action in (*_SHIPPED, *more):
        other = table.setdefault(action.__name__, action)
        if other is not action:
            where = f"in {other.__module__} and in {action.__module__}"
            fault = f"two actions are named '{action.__name__}', {where}."
            raise InputError(Fault(fault, hint="Rename one of them."))
    return MappingProxyType(table)


ACTIONS: Mapping[str, type[Action]] = action_table()
"""Shipped actions, keyed by class name."""
