"""Action table: maps the names of actions, as used in files and leaves, to action classes."""

from __future__ import annotations

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
            raise InputError(
                Fault(
                    f"two actions are named '{action.__name__}', in {other.__module__} and in {action.__module__}.",
                    hint="Rename one of them.",
                )
            )
    return MappingProxyType(table)


ACTIONS: Mapping[str, type[Action]] = action_table()
"""Shipped actions, keyed by class name."""
