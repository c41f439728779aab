"""What an agent knew over a run: as a story of changes, drawn, and as a page."""

from .drawing import draw
from .learnt import Learnt, learnt, value_text
from .page import render_knowledge
from .standpoint import RecordedSignals, recorded_asker
from .story import Story, story_of_history, story_of_recording, story_of_state

__all__ = [
    "Learnt",
    "RecordedSignals",
    "Story",
    "draw",
    "learnt",
    "recorded_asker",
    "render_knowledge",
    "story_of_history",
    "story_of_recording",
    "story_of_state",
    "value_text",
]
