"""Detection of a robot that has fallen (docs/architecture.md, outcomes)."""

from __future__ import annotations

import math

GROUND_CONTACT = 0.5
"""Duration of a ground contact of a wrong geom after which a robot is down [s]."""

TILT_LIMIT = math.radians(60.0)
"""Tilt beyond which a robot is down [rad]."""

RECOVERY = 5.0
"""Time within which a robot that is down must be upright again; otherwise it has fallen [s]."""

_APART = 0.2  # [s] minimum interruption that ends a ground contact
_SLACK = 1e-9  # [s] rounding tolerance of times


class FallWatch:
    """Timer of the time for which a robot is down: tilted, or on the ground with a wrong part."""

    def __init__(self) -> None:
        self.reason = ""  # why it is down now; empty if it is upright
        self._down_since = math.inf
        self._contact: tuple[float, str] | None = None  # begin of the present ground contact, and its geom
        self._contact_last = -math.inf

    def update(self, t: float, tilt: float, ground: str) -> bool:
        """Process one control period; returns True if the robot has fallen.

        Args:
            t: Time [s].
            tilt: Angle between the body's z axis and the vertical [rad].
            ground: Geom that touches the ground and should not; empty if there is none.
        """
        if not ground and tilt <= TILT_LIMIT and self._contact is None and not self.reason:
            return False  # the common case
        if ground:
            self._contact, self._contact_last = self._contact or (t, ground), t
        elif t - self._contact_last > _APART:
            self._contact = None
        reason = ""
        if tilt > TILT_LIMIT:
            reason = f"it tilted by more than {math.degrees(TILT_LIMIT):g} deg at {t:.2f} s"
        elif self._contact is not None and t - self._contact[0] >= GROUND_CONTACT - _SLACK:
            reason = "its {1} touched the ground from {0:.2f} s on".format(*self._contact)
        if not reason:
            self.reason, self._down_since = "", math.inf
        elif not self.reason:
            self.reason, self._down_since = reason, t
        return t - self._down_since >= RECOVERY - _SLACK
