"""MuJoCo backend: the simulated world of an arena and robots, and the devices of the robots.

MuJoCo itself is imported only when a world is constructed.
"""

from .actuators import ACTUATORS, MujocoActuator, Velocity, make_actuator
from .body import Controls, Motors
from .compose import FreeObject, RobotInstance, SensorMount, compile_model, compose_world
from .lidar import Rays
from .mount import DriverWorld, Mount
from .nearness import Near
from .odometer import Odometer
from .sensor import MujocoSensor
from .sensors import SENSORS, PoseSensor, make_sensor
from .world import Contact, MujocoWorld

__all__ = [
    "ACTUATORS",
    "SENSORS",
    "Contact",
    "Controls",
    "DriverWorld",
    "FreeObject",
    "Motors",
    "Mount",
    "MujocoActuator",
    "MujocoSensor",
    "MujocoWorld",
    "Near",
    "Odometer",
    "PoseSensor",
    "Rays",
    "RobotInstance",
    "SensorMount",
    "Velocity",
    "compile_model",
    "compose_world",
    "make_actuator",
    "make_sensor",
]
