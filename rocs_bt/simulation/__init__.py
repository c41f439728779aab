"""World of a scenario: compiled model, robots with devices, scripted actors and objects, and the judges of outcomes."""

from .feasible import POSES_TRIED, FreePose, free_goal_poses
from .outcome import OUTCOMES, AgentOutcome, Goal, Judge
from .physics_thread import PhysicsThread, run_physics
from .placement import place_all
from .random_streams import stream
from .scripted_object import ScriptedObject
from .scripted_robots import ScriptedRobot
from .scripts import SCRIPTED_OBJECTS, SCRIPTED_ROBOTS
from .simulated_device import simulated_device
from .simulated_world import SimulatedWorld, build_world, compose_scenario

__all__ = [
    "OUTCOMES",
    "POSES_TRIED",
    "SCRIPTED_OBJECTS",
    "SCRIPTED_ROBOTS",
    "AgentOutcome",
    "FreePose",
    "Goal",
    "Judge",
    "PhysicsThread",
    "ScriptedObject",
    "ScriptedRobot",
    "SimulatedWorld",
    "build_world",
    "compose_scenario",
    "free_goal_poses",
    "place_all",
    "run_physics",
    "simulated_device",
    "stream",
]
