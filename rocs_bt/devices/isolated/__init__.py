"""Isolated actuators: each has its driver in a separate small process with a watchdog.

The watchdog acts even if the main process is dead, was stopped, or its interpreter is blocked by a call that does not
return. The separate process imports only this package and its dependencies, so that it starts quickly.
"""

from .actuator import IsolatedActuator
from .maker import ActuatorMaker, DeviceMaker

__all__ = ["ActuatorMaker", "DeviceMaker", "IsolatedActuator"]
