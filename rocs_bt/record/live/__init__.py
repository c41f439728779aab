"""Live page: a running episode in a browser, drawn from the recorded events.

The run passes its events to a `LivePage`, and a separate process serves them to browsers. The cost for the run is one
list append per event and one encoding at 10 Hz, independent of the number of browsers and the size of the tree.
"""

from .page import RATE, LivePage

__all__ = ["RATE", "LivePage"]
