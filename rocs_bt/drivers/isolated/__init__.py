"""Isolated actuators: the link to the device lives in a small process of its own, with a watchdog of its own.

The watchdog acts even if the main process is dead, stopped, or its interpreter is held by a call that does not return.
The process imports nothing of the engine but what is imported here: it starts quickly and stays small.
"""

from .actuator import IsolatedActuator
from .maker import DeviceMaker

__all__ = ["DeviceMaker", "IsolatedActuator"]
