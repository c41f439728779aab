"""Free ground and gaps around the robot, as reported by its signals."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..control.arcs import BENDS, HEADINGS, STRAIGHT
from ..control.body_values import corner_sweep as hull_sweep
from ..control.locomotion import Array
from ..interfaces.action import Body

BEHIND = 0.25
"""Gap that the robot keeps to obstacles behind it [m]."""


GROUPS = ("front", "left_gap", "right_gap", "rear")
NOWHERE = np.full(4, math.nan)


class Room(NamedTuple):
    """Distances that the robot can drive over ground that is known to be free [m]; 0 where unknown."""

    ahead: Array  # (n,) forward on each of `control.arcs.BENDS`
    behind: Array  # (n,) backward on each of them
    turned: Array  # (m,) straight after a turn on the spot to each of `control.arcs.HEADINGS`

    @classmethod
    def none(cls) -> Room:
        """No free ground: all distances 0."""
        return cls(np.zeros(len(BENDS)), np.zeros(len(BENDS)), np.zeros(len(HEADINGS)))

    @classmethod
    def known(cls, body: Body) -> Room:
        """Present values of the signals `room_ahead`, `room_behind` and `room_turned`; 0 for missing signals."""
        signals, now = body.knowledge.signals, body.clock.now()
        names = {name: f"room_{name}" for name in cls._fields}
        known = {name: np.fmax(signals.read(signal, now), 0.0) for name, signal in names.items() if signal in signals}
        return cls.none()._replace(**known)


class Gaps(NamedTuple):
    """Gaps around the robot: the minimum of each standard group of ranges [m]; all NaN if one is unknown."""

    front: float
    left: float
    right: float
    rear: float

    @classmethod
    def known(cls, body: Body) -> Gaps:
        """Present gaps from the signals `front`, `left_gap`, `right_gap` and `rear`."""
        signals, now = body.knowledge.signals, body.clock.now()
        groups = [signals.read(name, now) if name in signals else NOWHERE for name in GROUPS]
        least = [float(group.min()) for group in groups]
        return cls(*least) if not any(map(math.isnan, least)) else cls(*NOWHERE)


def corner_sweep(body: Body) -> float:
    """Width beside the hull that its corners sweep in a turn on the spot [m]; NaN if the hull's size is unknown."""
    robot = body.knowledge.graph.attributes(body.knowledge.agent)
    length, width = robot.get("length") or math.nan, robot.get("width") or math.nan
    return hull_sweep(length, width)


def room_back(body: Body) -> float:
    """Free distance straight back [m], at least `BEHIND` from the obstacles behind; 0 if unknown."""
    signals = body.knowledge.signals
    rear = signals.read("rear", body.clock.now()).min() if "rear" in signals else math.nan
    room = float(np.minimum(Room.known(body).behind[STRAIGHT], rear - BEHIND))
    return room if room > 0.0 else 0.0


def may_turn(body: Body) -> bool:
    """Whether a turn on the spot to at least one heading is free, by the signal `room_turned`; true without it."""
    signals = body.knowledge.signals
    return "room_turned" not in signals or bool((signals.read("room_turned", body.clock.now()) > 0.0).any())


def free_turn(body: Body, turn: float) -> float:
    """Limit a turn on the spot to the angles in the signal `free_turn`; without this signal it is not limited.

    An invalid signal does not limit the turn. The signal is invalid only when the pose is, and then the turn stops
    anyway.

    Args:
        body: Robot.
        turn: Requested turn, left positive [rad].

    Returns:
        Allowed turn, left positive [rad].
    """
    signals = body.knowledge.signals
    if "free_turn" not in signals:
        return turn
    left, right = map(float, np.nan_to_num(signals.read("free_turn", body.clock.now()), nan=np.inf))
    return min(max(turn, -right), left)


def bend_off(body: Body, speed: float) -> float:
    """Curvature for backing off, from the signal `bend_off` [rad/m]; 0 without it.

    Args:
        body: Robot.
        speed: Speed; its sign selects the value for ahead or for back [m/s].
    """
    signals = body.knowledge.signals
    if "bend_off" not in signals:
        return 0.0
    ahead, back = signals.read("bend_off", body.clock.now()).tolist()
    bend = float(ahead if speed > 0.0 else back)
    return 0.0 if math.isnan(bend) else bend
