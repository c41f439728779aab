"""MuJoCo: a world of one arena and its robots, and the devices that live in it. MuJoCo is imported when one is made."""

from .actuators import ACTUATORS, make_actuator
from .compose import Placed, SensorMount, compose_world
from .sensors import SENSORS, Mount, MujocoSensor, make_sensor
from .world import Contact, MujocoWorld

__all__ = [
    "ACTUATORS",
    "SENSORS",
    "Contact",
    "Mount",
    "MujocoSensor",
    "MujocoWorld",
    "Placed",
    "SensorMount",
    "compose_world",
    "make_actuator",
    "make_sensor",
]
