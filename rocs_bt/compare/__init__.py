"""Planners over scenes, many times: episodes, metrics, statistics, verdicts."""

from ..catalog import PlannerSpec
from ..plan import Observation, PythonPlanner, Task
from .bench import Bench, Setting
from .building import Building, door_name, gate_name, room_name
from .cluster import dask_executor
from .comparison import Comparison, Disagreement
from .family import AGENT, Driver, Family, Scene, family_parameters, load_family
from .ground import Block, Grid, Ground, Post, Way, clearance_of, length_of, shortest_cells, walls_around
from .key import Keys
from .metric import METRICS, Measured, Metric, measure_all, metric
from .pool import WorkerDied, WorkerPool
from .record import OUTCOMES, EpisodeRecord, decode_record, encode_record
from .replay import parameters_given, place_named, play_again, replay_command
from .scene_text import as_speed, as_toml, degrees, goal_scenario, metres, seconds
from .store import Cost, Store
from .sweep import WALL_LIMIT, Sweep, cores, sweep
from .trial import FamilyScene, Place, ScenarioScene, Trial, scenes_of
from .verdict import Verdict

__all__ = [
    "AGENT",
    "METRICS",
    "OUTCOMES",
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
    "Grid",
    "Ground",
    "Keys",
    "Measured",
    "Metric",
    "Observation",
    "Place",
    "PlannerSpec",
    "Post",
    "PythonPlanner",
    "ScenarioScene",
    "Scene",
    "Setting",
    "Store",
    "Sweep",
    "Task",
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
    "replay_command",
    "room_name",
    "scenes_of",
    "seconds",
    "shortest_cells",
    "sweep",
    "walls_around",
]
