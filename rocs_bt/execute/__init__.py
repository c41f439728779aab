"""E: takes actions from the pipeline, decomposes them, acts them, and commands the actuators (paper, 4.2)."""

from .atomic_executor import AtomicActionExecutor
from .body import CommandedActuator, RobotBody
from .decomposer import ActionDecomposer
from .execute import BehaviorPipeline, Execute

__all__ = [
    "ActionDecomposer",
    "AtomicActionExecutor",
    "BehaviorPipeline",
    "CommandedActuator",
    "Execute",
    "RobotBody",
]
