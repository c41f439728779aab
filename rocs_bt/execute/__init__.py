"""Execute block of MAPE-K: takes actions from the pipeline, decomposes and executes them (paper, 4.2).

Only `agent` and the packages above it import this package.
"""

from .body import CommandedActuator, RobotBody
from .decomposer import ActionDecomposer
from .execute import AtomicActionExecutor, BehaviorPipeline, Execute

__all__ = [
    "ActionDecomposer",
    "AtomicActionExecutor",
    "BehaviorPipeline",
    "CommandedActuator",
    "Execute",
    "RobotBody",
]
