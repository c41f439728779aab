"""Why an endpoint of this robot has no counterpart on the network, and what to change."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from .qos import QoS, mismatch
from .transport import Endpoint

KEYS = ("reliability", "durability")
"""Policies that robot.toml declares, by key."""


@dataclass(frozen=True, eq=False)
class Side:
    """Place where type and quality of service of an endpoint are written."""

    name: str
    editable: bool = True  # whether a user writes type and quality
    # Values of `qos` of a mission's node; empty for robot.toml, with a key for each policy.
    qualities: Mapping[str, QoS] = field(default_factory=dict)

    def other_type(self, type: str) -> str:
        """What to change for a counterpart with this type."""
        equals = "=" if self.qualities else " = "
        return f'; write type{equals}"{type}", or change the other node' if self.editable else ""

    def other_qos(self, ours: QoS, theirs: QoS, *, publishes: bool) -> str:
        """What to change for a counterpart with another quality of service; `publishes`: whether this side does."""

        def fits(each: QoS) -> bool:
            return not (mismatch(each, theirs) if publishes else mismatch(theirs, each))

        named = [f'qos="{name}"' for name, each in self.qualities.items() if fits(each)][:1]
        differ = [f'{key} = "{getattr(theirs, key)}"' for key in KEYS if getattr(ours, key) != getattr(theirs, key)]
        change = named if self.qualities else differ
        return f"; write {' and '.join(change)}, or change the other node" if change and self.editable else ""


FILE = Side("robot.toml")
FIXED = Side("rocs_bt", editable=False)


@dataclass(frozen=True)
class OwnEndpoint:
    """Publisher or subscription of this robot."""

    topic: str
    type: str
    qos: QoS
    publishes: bool = False
    side: Side = FILE

    def found(self, endpoints: Sequence[Endpoint]) -> list[Endpoint]:
        """Discovered counterparts of the topic, whether they match or not."""
        return [each for each in endpoints if each.topic == self.topic and each.publishes != self.publishes]

    def matches(self, other: Endpoint) -> bool:
        """Whether a counterpart of the topic matches."""
        return not self.problem(other)

    def mismatch(self, endpoints: Sequence[Endpoint]) -> str:
        """Reason why no counterpart matches; empty if one does, or there is none."""
        found = sorted(self.found(endpoints), key=lambda each: each.type != self.type)
        return "" if any(map(self.matches, found)) else "".join(map(self.problem, found[:1]))

    def problem(self, other: Endpoint) -> str:
        """Reason why a counterpart of the topic does not match; empty if it does."""
        wanted, side = f"'{self.topic}' ({self.type})", self.side
        if other.type != self.type:
            does = "subscribes to" if self.publishes else "publishes"
            return f"{wanted}: {other.owner} {does} {other.type}, which is another type{side.other_type(other.type)}"
        if not (differ := mismatch(self.qos, other.qos) if self.publishes else mismatch(other.qos, self.qos)):
            return ""
        verbs = ("requests", "offers") if self.publishes else ("offers", "requests")
        sides = f"it {verbs[0]} {other.qos}, {side.name} {verbs[1]} {self.qos}"
        why = f"the quality of service of {other.owner} does not match in {differ}"
        return f"{wanted}: {why}: {sides}{side.other_qos(self.qos, other.qos, publishes=self.publishes)}"
