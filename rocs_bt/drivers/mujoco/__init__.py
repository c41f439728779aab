"""MuJoCo: a world of one arena and its robots, and the devices that live in it. MuJoCo is imported when one is made."""

from .actuators import ACTUATORS, MujocoActuator, make_actuator
from .body import Motors
from .compose import Placed, SensorMount, compile_model, compose_world
from .mount import DriverWorld, Mount
from .sensor import MujocoSensor
from .sensors import SENSORS, make_sensor
from .world import Contact, MujocoWorld

__all__ = [
    "ACTUATORS",
    "SENSORS",
    "Contact",
    "DriverWorld",
    "Motors",
    "Mount",
    "MujocoActuator",
    "MujocoSensor",
    "MujocoWorld",
    "Placed",
    "SensorMount",
    "compile_model",
    "compose_world",
    "make_actuator",
    "make_sensor",
]
