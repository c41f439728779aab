"""Devices of tests behind a safety gate whose limits no test command reaches."""

from rocs_bt.interfaces.actuator_limits import ActuatorLimits
from rocs_bt.interfaces.safety_gate import SafetyGate


def wide_gate(device, clock, sink=None):
    """The device behind limits of 100 either way, without a limit of change."""
    return SafetyGate(device, clock, ActuatorLimits((-100.0,), (100.0,)), period=0.05, max_age=0.2, sink=sink)
