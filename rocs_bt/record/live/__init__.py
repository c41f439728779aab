"""The live page: a run while it goes on, in any browser, drawn from the same events that are recorded.

The run hands its events to a `LivePage`, which has a process of its own serve them: however many browsers look on,
and however large a tree is, the run pays for a list append an event and for one encoding ten times a second.
"""

from .page import RATE, LivePage

__all__ = ["RATE", "LivePage"]
