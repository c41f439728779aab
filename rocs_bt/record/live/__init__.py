"""Live page: a running episode in a browser, drawn from the recorded events.

The run passes its events to a `LivePage`, and a separate process serves them to browsers. The run only appends each
event to a list and encodes new events at 10 Hz. This cost does not depend on the number of browsers or the size of the
tree.
"""

from .page import RATE, LivePage

__all__ = ["RATE", "LivePage"]
