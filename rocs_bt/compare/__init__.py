"""Compare planners over many scenes: episodes, metrics, statistics, verdicts.

Episodes run in `simulation`. The command line and the pytest plugin import this package. It exports what a family of
scenes and a comparison need; the rest is in the submodules.
"""

from .building import Building, TaskFamily
from .comparison import Comparison
from .episode import FamilyScene, ScenarioScene, scenes_of
from .family import Family, Scene, goal_scenario, load_family, position, quantity
from .floor_grid import shortest_cells
from .ground import Ground
from .obstacle import Block, Post, length_of, walls_around
from .run_sweep import SweepOptions, sweep
from .store import Store

__all__ = [
    "Block",
    "Building",
    "Comparison",
    "Family",
    "FamilyScene",
    "Ground",
    "Post",
    "ScenarioScene",
    "Scene",
    "Store",
    "SweepOptions",
    "TaskFamily",
    "goal_scenario",
    "length_of",
    "load_family",
    "position",
    "quantity",
    "scenes_of",
    "shortest_cells",
    "sweep",
    "walls_around",
]
