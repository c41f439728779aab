"""Knowledge of an agent over a run: change log from a recording, and a drawing."""

from .drawing import draw
from .recorded import recorded_context, recorded_log

__all__ = [
    "draw",
    "recorded_context",
    "recorded_log",
]
