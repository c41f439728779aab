"""P: decides what to do next, with a behaviour tree or a user's own planner (paper, 4.2 and 5.2)."""

from .act import Act
from .action_node import ActionNode, action_nodes
from .check import check_mission
from .condition import Condition
from .content import Content
from .mission import Mission
from .own_actions import mission_actions
from .parameters import mission_arguments, mission_parameters
from .plan import Plan
from .question import Question
from .route import NoRoute, Point, RoutePlanner
from .tree import NodeOutline, TreePlan
from .wait import Wait

__all__ = [
    "Act",
    "ActionNode",
    "Condition",
    "Content",
    "Mission",
    "NoRoute",
    "NodeOutline",
    "Plan",
    "Point",
    "Question",
    "RoutePlanner",
    "TreePlan",
    "Wait",
    "action_nodes",
    "check_mission",
    "mission_actions",
    "mission_arguments",
    "mission_parameters",
]
