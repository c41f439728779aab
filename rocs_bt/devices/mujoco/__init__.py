"""MuJoCo: the simulated world of an arena and robots, a `Scene`, and base classes of users' devices in it.

MuJoCo itself is imported only when a world is constructed.
"""

from .body import Controls, Motors
from .compose import FreeObject, RobotInstance, SensorMount, compile_model, compose_world
from .device import MujocoActuator, MujocoSensor
from .nearness import Near
from .rays import Rays
from .world import Contact, MujocoWorld

__all__ = [
    "Contact",
    "Controls",
    "FreeObject",
    "Motors",
    "MujocoActuator",
    "MujocoSensor",
    "MujocoWorld",
    "Near",
    "Rays",
    "RobotInstance",
    "SensorMount",
    "compile_model",
    "compose_world",
]
