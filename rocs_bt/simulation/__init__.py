"""A world, its agents and movers: one episode, from a scenario's file to its outcome."""

from .episode import Episode, Mind, Result
from .feasible import POSES_TRIED, FreePose, free_goal_poses
from .metrics import Metrics
from .mover import MOVERS, Mover, make_mover
from .outcome import OUTCOMES, Goal, Judge, Verdict
from .physics_thread import PhysicsThread, run_physics
from .placement import place_all
from .replay import replay
from .run import RunResult, run
from .sink_thread import SinkThread
from .stage import Stage, compose_scenario, set_stage
from .streams import stream

__all__ = [
    "MOVERS",
    "OUTCOMES",
    "POSES_TRIED",
    "Episode",
    "FreePose",
    "Goal",
    "Judge",
    "Metrics",
    "Mind",
    "Mover",
    "PhysicsThread",
    "Result",
    "RunResult",
    "SinkThread",
    "Stage",
    "Verdict",
    "compose_scenario",
    "free_goal_poses",
    "make_mover",
    "place_all",
    "replay",
    "run",
    "run_physics",
    "set_stage",
    "stream",
]
