"""Compare planners over many scenes: episodes, metrics, statistics, verdicts.

Episodes run in `simulation`. The command line and the pytest plugin use this package. It exports the names needed to
write a family of scenes or a comparison; all others are in its modules.
"""

from .building import Building, TaskFamily
from .comparison import Comparison
from .episode import FamilyScene, ScenarioScene, scenes_of
from .family import Family, Scene, goal_scenario, load_family, position, quantity
from .floor import Floor
from .floor_grid import shortest_cells
from .obstacle import Block, Post, length_of, walls_around
from .people import PeopleFamily, TrafficFamily, Walk, one_of
from .run_sweep import SweepOptions, sweep
from .store import EpisodeStore

__all__ = [
    "Block",
    "Building",
    "Comparison",
    "EpisodeStore",
    "Family",
    "FamilyScene",
    "Floor",
    "PeopleFamily",
    "Post",
    "ScenarioScene",
    "Scene",
    "SweepOptions",
    "TaskFamily",
    "TrafficFamily",
    "Walk",
    "goal_scenario",
    "length_of",
    "load_family",
    "one_of",
    "position",
    "quantity",
    "scenes_of",
    "shortest_cells",
    "sweep",
    "walls_around",
]
