"""Quality of service of ROS 2 endpoints: the policies that decide whether a publisher and a subscription match."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ...base.errors import Fault, InputError

RELIABILITIES = ("reliable", "best_effort")
DURABILITIES = ("volatile", "transient_local")


@dataclass(frozen=True)
class QoS:
    """Quality of service of an endpoint.

    Attributes:
        reliability: `reliable` (lost messages are sent again) or `best_effort`.
        durability: `volatile`, or `transient_local` (latched: late subscriptions get the last messages).
        depth: Number of messages that are kept for an application that has not taken them.

    Raises:
        InputError: A policy is unknown, or the depth is not positive.
    """

    reliability: str = "reliable"
    durability: str = "volatile"
    depth: int = 1

    SENSOR: ClassVar[QoS]
    COMMAND: ClassVar[QoS]
    LATCHED: ClassVar[QoS]

    def __post_init__(self) -> None:
        policies = (
            ("reliability", self.reliability, RELIABILITIES),
            ("durability", self.durability, DURABILITIES),
        )
        faults = [
            Fault(f"{name} must be {' or '.join(known)}, found '{value}'.")
            for name, value, known in policies
            if value not in known
        ]
        if self.depth < 1:
            faults.append(Fault(f"depth must be at least 1 message, found {self.depth}."))
        if faults:
            raise InputError(*faults)

    def __str__(self) -> str:
        return f"{self.reliability}, {self.durability}, depth {self.depth}"


QoS.SENSOR = QoS("best_effort", "volatile", 5)
QoS.COMMAND = QoS("reliable", "volatile", 1)
QoS.LATCHED = QoS("reliable", "transient_local", 1)


def mismatch(offered: QoS, requested: QoS) -> str:
    """Incompatible policies of a publisher and a subscription, with both sides' values; empty if they match."""
    found = []
    if requested.reliability == "reliable" and offered.reliability == "best_effort":
        found.append("reliability (offered best_effort, requested reliable)")
    if requested.durability == "transient_local" and offered.durability == "volatile":
        found.append("durability (offered volatile, requested transient_local)")
    return " and ".join(found)
