"""Isolated actuators: the driver runs in a separate small process with a watchdog.

The watchdog acts even if the main process is dead, stopped, or its interpreter is blocked by a call that does not
return. The process imports only the engine modules that are imported here, so it starts quickly and stays small.
"""

from .actuator import IsolatedActuator
from .maker import DeviceMaker

__all__ = ["DeviceMaker", "IsolatedActuator"]
