"""Plan block of MAPE-K: decides what to do next, with a behaviour tree or a user's own planner (paper, 4.2 and 5.2).

The package connects the trees of `rocs_bt.trees` to an agent. Only `agent`, the packages above it, and missions import
it.
"""

from .act import Act
from .action_node import ActionNode, action_nodes
from .context import CheckOptions, Content, MissionContext, SignalCondition, mission_of
from .dialects import shipped_nodes
from .leaves import Condition, Wait
from .mission import Mission
from .mission_check import checked_plan, mission_faults
from .parameters import mission_actions, mission_arguments, mission_parameters
from .plan import Plan
from .python_planner import Observation, PythonPlan, PythonPlanner, Task, python_mission
from .route import NO_PATH, MapRoutePlanner, NoRoute, Point, RoadRoutePlanner, RoutePlanner, distance_to_path
from .tree import NodeOutline, TreePlan
from .vehicle import Vehicle
from .xml_mission import mission_nodes, xml_mission

__all__ = [
    "NO_PATH",
    "Act",
    "ActionNode",
    "CheckOptions",
    "Condition",
    "Content",
    "MapRoutePlanner",
    "Mission",
    "MissionContext",
    "NoRoute",
    "NodeOutline",
    "Observation",
    "Plan",
    "Point",
    "PythonPlan",
    "PythonPlanner",
    "RoadRoutePlanner",
    "RoutePlanner",
    "SignalCondition",
    "Task",
    "TreePlan",
    "Vehicle",
    "Wait",
    "action_nodes",
    "checked_plan",
    "distance_to_path",
    "mission_actions",
    "mission_arguments",
    "mission_faults",
    "mission_nodes",
    "mission_of",
    "mission_parameters",
    "python_mission",
    "shipped_nodes",
    "xml_mission",
]
