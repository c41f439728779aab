"""E of MAPE-K: takes actions from the pipeline, decomposes and executes them (paper, 4.2).

Imported by `agent` and the layers above; the other blocks never import it.
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
