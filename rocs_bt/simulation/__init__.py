"""A world, its agents and movers: one episode, from a scenario's file to its outcome; the same agents on hardware.

Imported by `compare`, `check`, the command line and the pytest plugin.
"""

from ..drivers.host import Host
from .carried import CARRIERS, Carrier, make_carrier
from .devices import Driver, hardware_driver, mujoco_driver
from .episode import Episode, Result
from .feasible import POSES_TRIED, FreePose, free_goal_poses
from .hardware import drive
from .judging import Mind
from .metrics import Metrics
from .mover import MOVERS, Mover, make_mover
from .outcome import OUTCOMES, Goal, Judge, Verdict
from .physics_thread import PhysicsThread, run_physics
from .placement import place_all
from .replay import replay
from .requirements import Finding, RequirementWatch, check_recorded, requirement_faults, requirements_of
from .run import run
from .run_end import RunResult
from .run_files import REPORT, SUMMARY
from .sink_thread import SinkThread
from .stage import Stage, compose_scenario, set_stage
from .stop_signals import EndedAtOnce, StopSignals
from .streams import stream
from .summary import summary_of

__all__ = [
    "CARRIERS",
    "MOVERS",
    "OUTCOMES",
    "POSES_TRIED",
    "REPORT",
    "SUMMARY",
    "Carrier",
    "Driver",
    "EndedAtOnce",
    "Episode",
    "Finding",
    "FreePose",
    "Goal",
    "Host",
    "Judge",
    "Metrics",
    "Mind",
    "Mover",
    "PhysicsThread",
    "RequirementWatch",
    "Result",
    "RunResult",
    "SinkThread",
    "Stage",
    "StopSignals",
    "Verdict",
    "check_recorded",
    "compose_scenario",
    "drive",
    "free_goal_poses",
    "hardware_driver",
    "make_carrier",
    "make_mover",
    "mujoco_driver",
    "place_all",
    "replay",
    "requirement_faults",
    "requirements_of",
    "run",
    "run_physics",
    "set_stage",
    "stream",
    "summary_of",
]
