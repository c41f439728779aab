"""Knowledge of an agent over a run: change log from a recording, drawing, table and HTML page."""

from .drawing import draw
from .learnt import Learnt, learnt, value_text
from .page import render_knowledge
from .recorded import RecordedSignals, recorded_context, recorded_log

__all__ = [
    "Learnt",
    "RecordedSignals",
    "draw",
    "learnt",
    "recorded_context",
    "recorded_log",
    "render_knowledge",
    "value_text",
]
