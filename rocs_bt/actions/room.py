"""How much room a robot has, as the monitor of its surroundings tells; a robot without one knows of none."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..action import Body
from ..control.arcs import BENDS, HEADINGS, STRAIGHT
from ..control.drive import Array

BEHIND = 0.25
"""What it leaves to what is behind [m]."""


GROUPS = ("front", "left_gap", "right_gap", "rear")
NOWHERE = np.full(4, math.nan)


class Room(NamedTuple):
    """How far a robot may drive on ground that it knows to be free [m]; nowhere where nobody knows."""

    ahead: Array  # (n,) on each of `control.arcs.BENDS`
    behind: Array  # (n,) back on each of them
    turned: Array  # (m,) to each of `control.arcs.HEADINGS`, once turned there on the spot

    @classmethod
    def none(cls) -> Room:
        """Where nobody knows."""
        return cls(np.zeros(len(BENDS)), np.zeros(len(BENDS)), np.zeros(len(HEADINGS)))

    @classmethod
    def known(cls, body: Body) -> Room:
        """What the signals `room_ahead`, `room_behind` and `room_turned` tell now."""
        signals, now = body.knowledge.signals, body.clock.now()
        names = {name: f"room_{name}" for name in cls._fields}
        known = {name: np.fmax(signals.read(signal, now), 0.0) for name, signal in names.items() if signal in signals}
        return cls.none()._replace(**known)


class Gaps(NamedTuple):
    """Least value of each standard group [m]: the gaps around the robot; all NaN while one of them is not known."""

    front: float
    left: float
    right: float
    rear: float

    @classmethod
    def known(cls, body: Body) -> Gaps:
        """The gaps by the signals `front`, `left_gap`, `right_gap` and `rear` now."""
        signals, now = body.knowledge.signals, body.clock.now()
        groups = [signals.read(name, now) if name in signals else NOWHERE for name in GROUPS]
        least = [float(group.min()) for group in groups]
        return cls(*least) if not any(map(math.isnan, least)) else cls(*NOWHERE)


def corner_sweep(body: Body) -> float:
    """Width beside the hull that its corners sweep in a turn on the spot [m]; NaN if its size is not declared."""
    robot = body.knowledge.graph.attributes(body.knowledge.agent)
    length, width = robot.get("length") or math.nan, robot.get("width") or math.nan
    return 0.5 * (math.hypot(length, width) - width)


def room_back(body: Body) -> float:
    """How far the robot may drive straight back [m], over free ground and not up to who is behind; 0 if not known."""
    signals = body.knowledge.signals
    rear = signals.read("rear", body.clock.now()).min() if "rear" in signals else math.nan
    room = float(np.minimum(Room.known(body).behind[STRAIGHT], rear - BEHIND))
    return room if room > 0.0 else 0.0


def may_turn(body: Body) -> bool:
    """Whether all is known to be free where a turn on the spot brings the robot, and on; true where nobody tells."""
    signals = body.knowledge.signals
    return "room_turned" not in signals or bool((signals.read("room_turned", body.clock.now()) > 0.0).any())


def free_turn(body: Body, turn: float) -> float:
    """As much of a turn on the spot [rad], left positive, as the signal `free_turn` allows; all where nobody knows.

    While the signal is invalid it bars nothing: a turn needs the same pose, and stands without.
    """
    signals = body.knowledge.signals
    if "free_turn" not in signals:
        return turn
    left, right = map(float, np.nan_to_num(signals.read("free_turn", body.clock.now()), nan=np.inf))
    return min(max(turn, -right), left)


def bend_off(body: Body, speed: float) -> float:
    """On which bend [rad/m] the robot goes off ahead, or back, as the signal `bend_off` tells; straight without it."""
    signals = body.knowledge.signals
    if "bend_off" not in signals:
        return 0.0
    ahead, back = signals.read("bend_off", body.clock.now()).tolist()
    bend = float(ahead if speed > 0.0 else back)
    return 0.0 if math.isnan(bend) else bend
