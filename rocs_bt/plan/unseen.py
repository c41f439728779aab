"""Goals that are no place that the robot knows of."""

from __future__ import annotations

from collections.abc import Collection

from ..errors import Fault, unknown
from ..knowledge import WorldModel


def unseen_goal(world: WorldModel, action: str, goal: str, later: Collection[str] | None) -> Fault | None:
    """The fault of an action whose goal has no pose at the start; None for none.

    Where the robot knows of no place at all, nothing is said.

    Args:
        world: What the robot knows at the start.
        action: The action.
        goal: Its goal.
        later: Nodes that may become known during the run; None where any may. The goal is an error where it is none of
            them, else a warning.
    """
    known = [*world.goals(), *world.places(), *world.objects(), *world.peers()]
    if not known or world.pose_of(goal) is not None:
        return None
    if goal in known:
        hint = f"{action} fails unless it is found on the way."
        return Fault(f"the position of '{goal}' is not known at the start.", hint=hint, warning=True)
    found = unknown("place", goal, known, "The world")
    if later is not None and goal not in later and not world.graph.has(goal):
        hint = f"{action} cannot reach it. If it becomes known only during the run, declare it in a [[fact]]."
        return Fault(found.message, hint=f"{found.hint} {hint}")
    return Fault(found.message, hint=f"{found.hint} {action} fails unless it is found on the way.", warning=True)
