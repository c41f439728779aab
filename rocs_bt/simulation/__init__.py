"""Run a scenario: one episode in simulation or on hardware, from the scenario's file to its outcome.

Imported by `compare`, `check`, the command line and the pytest plugin.
"""

from ..drivers.host import Host
from .devices import Driver, hardware_driver, mujoco_driver, on_hardware
from .episode import Episode, Result
from .feasible import POSES_TRIED, FreePose, free_goal_poses
from .hardware import drive_robots
from .judge_panel import EpisodeAgent
from .metrics import Metrics
from .options import MODES, Build, LiveView, RunChanges, RunOptions
from .outcome import OUTCOMES, Goal, Judge, Verdict
from .physics_thread import PhysicsThread, run_physics
from .placement import place_all
from .preflight import PreflightReport, SensorState
from .random_streams import stream
from .replay import replay
from .requirements import RequirementWatch, check_recorded, requirement_faults, requirements_of
from .run_files import RECORDING, REPORT, SUMMARY
from .run_result import RunResult
from .scripted_objects import SCRIPTED_OBJECTS, ScriptedObject, make_scripted_object
from .scripted_robots import SCRIPTED_ROBOTS, ScriptedRobot, make_scripted_robot
from .simulate import simulate
from .simulated_world import SimulatedWorld, build_world, compose_scenario
from .sink_thread import SinkThread
from .stop_signals import EndedAtOnce, StopSignals
from .summary import summary_of
from .swaps import read_swap

__all__ = [
    "MODES",
    "OUTCOMES",
    "POSES_TRIED",
    "RECORDING",
    "REPORT",
    "SCRIPTED_OBJECTS",
    "SCRIPTED_ROBOTS",
    "SUMMARY",
    "Build",
    "Driver",
    "EndedAtOnce",
    "Episode",
    "EpisodeAgent",
    "FreePose",
    "Goal",
    "Host",
    "Judge",
    "LiveView",
    "Metrics",
    "PhysicsThread",
    "PreflightReport",
    "RequirementWatch",
    "Result",
    "RunChanges",
    "RunOptions",
    "RunResult",
    "ScriptedObject",
    "ScriptedRobot",
    "SensorState",
    "SimulatedWorld",
    "SinkThread",
    "StopSignals",
    "Verdict",
    "build_world",
    "check_recorded",
    "compose_scenario",
    "drive_robots",
    "free_goal_poses",
    "hardware_driver",
    "make_scripted_object",
    "make_scripted_robot",
    "mujoco_driver",
    "on_hardware",
    "place_all",
    "read_swap",
    "replay",
    "requirement_faults",
    "requirements_of",
    "run_physics",
    "simulate",
    "stream",
    "summary_of",
]
