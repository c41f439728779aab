from __future__ import annotations

import math

import pytest

from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.signal import Signal
from rocs_bt.base.units import ANGLE, LENGTH, SPEED
from rocs_bt.event import ListSink
from rocs_bt.knowledge import Knowledge


@pytest.fixture
def clock() -> SimulatedClock:
    return SimulatedClock(0.05)


@pytest.fixture
def sink() -> ListSink:
    return ListSink()


@pytest.fixture
def knowledge(clock: SimulatedClock, sink: ListSink) -> Knowledge:
    made = Knowledge("R2", clock, sink)
    made.signals.declare(Signal("front", 3, (LENGTH,), (0.0, math.inf), 0.15))
    made.signals.declare(Signal("pose", 3, (LENGTH, LENGTH, ANGLE), max_age=0.15))
    made.signals.declare(Signal("wheel_speeds", 2, (SPEED,), (-2.0, 2.0), 0.15))
    made.signals.declare(Signal("speed", 1, (SPEED,), (-2.0, 2.0), 0.15))
    return made
