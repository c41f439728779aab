"""Planners over scenes, many times: episodes, metrics, statistics, verdicts.

It runs episodes by `simulation`. Imported by the command line and the pytest plugin.
"""

from ..catalog import PlannerSpec
from ..plan import Observation, PythonPlanner, Task
from .bench import Bench, Setting
from .building import Building, Route, door_name, gate_name, position, room_name
from .cluster import dask_executor
from .comparison import Comparison, Disagreement
from .family import AGENT, Driver, Family, Scene, family_parameters, load_family
from .floor_grid import FloorGrid, Way, shortest_cells
from .ground import Ground
from .key import Keys
from .metric import JUDGED, METRICS, SHARES, Measured, Metric, measure_all, metric
from .pool import WorkerDied, WorkerPool
from .record import OUTCOMES, EpisodeRecord, decode_record, encode_record
from .replay import parameters_given, place_named, play_again, replay_command
from .scene_text import as_speed, as_toml, degrees, goal_scenario, metres, seconds
from .store import Cost, Store
from .sweep import WALL_LIMIT, Sweep, cores, sweep
from .task_family import TaskFamily
from .thing import Block, Post, clearance_of, length_of, walls_around
from .trial import FamilyScene, Place, ScenarioScene, Trial, scenes_of
from .verdict import Verdict

__all__ = [
    "AGENT",
    "JUDGED",
    "METRICS",
    "OUTCOMES",
    "SHARES",
    "WALL_LIMIT",
    "Bench",
    "Block",
    "Building",
    "Comparison",
    "Cost",
    "Disagreement",
    "Driver",
    "EpisodeRecord",
    "Family",
    "FamilyScene",
    "FloorGrid",
    "Ground",
    "Keys",
    "Measured",
    "Metric",
    "Observation",
    "Place",
    "PlannerSpec",
    "Post",
    "PythonPlanner",
    "Route",
    "ScenarioScene",
    "Scene",
    "Setting",
    "Store",
    "Sweep",
    "Task",
    "TaskFamily",
    "Trial",
    "Verdict",
    "Way",
    "WorkerDied",
    "WorkerPool",
    "as_speed",
    "as_toml",
    "clearance_of",
    "cores",
    "dask_executor",
    "decode_record",
    "degrees",
    "door_name",
    "encode_record",
    "family_parameters",
    "gate_name",
    "goal_scenario",
    "length_of",
    "load_family",
    "measure_all",
    "metres",
    "metric",
    "parameters_given",
    "place_named",
    "play_again",
    "position",
    "replay_command",
    "room_name",
    "scenes_of",
    "seconds",
    "shortest_cells",
    "sweep",
    "walls_around",
]
