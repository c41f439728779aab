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
from .python_planner import Observation, PythonPlan, PythonPlanner, Task, python_mission
from .question import Question
from .route import NoRoute, Point, RoadRoutePlanner, RoutePlanner, off_way
from .tree import NodeOutline, TreePlan
from .vehicle import Vehicle
from .wait import Wait

__all__ = [
    "Act",
    "ActionNode",
    "Condition",
    "Content",
    "Mission",
    "NoRoute",
    "NodeOutline",
    "Observation",
    "Plan",
    "Point",
    "PythonPlan",
    "PythonPlanner",
    "Question",
    "RoadRoutePlanner",
    "RoutePlanner",
    "Task",
    "TreePlan",
    "Vehicle",
    "Wait",
    "action_nodes",
    "check_mission",
    "mission_actions",
    "mission_arguments",
    "mission_parameters",
    "off_way",
    "python_mission",
]
