"""P: decides what to do next, with a behaviour tree or a user's own planner (paper, 4.2 and 5.2)."""

from .act import Act
from .check import check_mission
from .condition import Condition
from .mission import Mission
from .own_actions import mission_actions
from .parameters import mission_arguments, mission_parameters
from .plan import Plan
from .tree import NodeOutline, TreePlan
from .wait import Wait

__all__ = [
    "Act",
    "Condition",
    "Mission",
    "NodeOutline",
    "Plan",
    "TreePlan",
    "Wait",
    "check_mission",
    "mission_actions",
    "mission_arguments",
    "mission_parameters",
]
