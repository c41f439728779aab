"""Content catalog: finds robots, rules, missions, routes, nodes, scenarios and worlds by name and reads their files.

No other package finds content or loads Python content. `agent` and the layers above import the catalog; blocks
receive the loaded objects.
"""

from ..base.python_content import classes_in, functions_in, is_reference, load_class, running, running_class
from .catalog import CachingCatalog, Catalog
from .content_kinds import (
    IDENTIFIED,
    KINDS,
    PATTERNS,
    TREES,
    ContentKind,
    Entry,
    content_hash,
    find_project,
    is_path,
    kind_of,
    make_entry,
    shipped_root,
)
from .copying import copy_content
from .device_spec import ActuatorSpec, SensorSpec
from .finder import Finder
from .mission_catalog import MissionCatalog
from .perturbation import Perturbation, parse_perturbation, perturbed, read_perturbations
from .planner_file import PlannerSpec, mission_values, read_planner
from .robot_file import load_robot
from .robot_spec import AnalyzeSpec, MonitorSpec, RobotSpec, command_size
from .scenario_file import (
    ActorSpec,
    AgentSpec,
    PlaceSpec,
    RequirementSpec,
    ScenarioSpec,
    SuccessSpec,
    read_scenario,
)
from .scenario_tables import FactSpec, GroundSpec, PushSpec, RateSpec

__all__ = [
    "IDENTIFIED",
    "KINDS",
    "PATTERNS",
    "TREES",
    "ActorSpec",
    "ActuatorSpec",
    "AgentSpec",
    "AnalyzeSpec",
    "CachingCatalog",
    "Catalog",
    "ContentKind",
    "Entry",
    "FactSpec",
    "Finder",
    "GroundSpec",
    "MissionCatalog",
    "MonitorSpec",
    "Perturbation",
    "PlaceSpec",
    "PlannerSpec",
    "PushSpec",
    "RateSpec",
    "RequirementSpec",
    "RobotSpec",
    "ScenarioSpec",
    "SensorSpec",
    "SuccessSpec",
    "classes_in",
    "command_size",
    "content_hash",
    "copy_content",
    "find_project",
    "functions_in",
    "is_path",
    "is_reference",
    "kind_of",
    "load_class",
    "load_robot",
    "make_entry",
    "mission_values",
    "parse_perturbation",
    "perturbed",
    "read_perturbations",
    "read_planner",
    "read_scenario",
    "running",
    "running_class",
    "shipped_root",
]
