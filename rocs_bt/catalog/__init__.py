"""Finds robots, rules, missions, routes, nodes, scenarios and worlds by name, and reads their files."""

from .catalog import Catalog, find_project, is_path, shipped_root
from .entry import KINDS, Entry, content_hash, kind_of, make_entry
from .python_content import classes_in, functions_in, is_reference, load_class
from .robot_file import (
    ActuatorSpec,
    AnalyzeSpec,
    DriveSpec,
    MonitorSpec,
    RobotSpec,
    SensorSpec,
    load_robot,
    robot_drive,
)
from .scenario_file import AgentSpec, MoverSpec, PlaceSpec, RateSpec, RequirementSpec, ScenarioSpec, read_scenario

__all__ = [
    "KINDS",
    "ActuatorSpec",
    "AgentSpec",
    "AnalyzeSpec",
    "Catalog",
    "DriveSpec",
    "Entry",
    "MonitorSpec",
    "MoverSpec",
    "PlaceSpec",
    "RateSpec",
    "RequirementSpec",
    "RobotSpec",
    "ScenarioSpec",
    "SensorSpec",
    "classes_in",
    "content_hash",
    "find_project",
    "functions_in",
    "is_path",
    "is_reference",
    "kind_of",
    "load_class",
    "load_robot",
    "make_entry",
    "read_scenario",
    "robot_drive",
    "shipped_root",
]
