"""Names and values of tracks: the state of a reflex rule, the cause of a command, lines of the log."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from typing import Any, NamedTuple

import msgspec

from ...base.words import failed_again
from ...event import (
    BlackboardChanged,
    ContentRaised,
    Event,
    Level,
    MotionHeld,
    MotionReleased,
    OutcomeDecided,
    RuleChanged,
    ScriptActed,
    SensorFailed,
    TicketChanged,
)
from .actors import ActorMoved


class TrackKey(NamedTuple):
    """Name of a track: agent or body, topic, and name within the topic."""

    agent: str
    topic: str
    name: str = ""


class LogLine(NamedTuple):
    """Sentence about an event, with the track that it is about."""

    t: float  # [s]
    agent: str
    level: Level
    text: str
    about: TrackKey | None


class RuleState(msgspec.Struct, frozen=True, omit_defaults=True):
    """State of a reflex rule.

    Attributes:
        phase: Phase of its last event.
        last: Values of its guard at its last event; may be empty.
        priority: Priority of the rule.
        latched: Whether the rule is latched.
        active: Whether its action is the robot's.
        waits: Whether it waits behind another reflex.
        behind: The rule that was active when it last began to wait.
        fired: Number of its activations so far.
        again: Number of times that it fired again in the last activation.
        firing: Time [s], phase and values of its guard when it last fired.
        cause: Time [s] and values of its guard when it latched, before it last fired.
        latch: Time [s] and values of its guard when it last latched.
        reading: Values of its guard at its last change.
        parameters: Parameters of its action at its last change, SI units.
    """

    phase: str = ""
    last: str = ""
    priority: int = 0
    latched: bool = False
    active: bool = False
    waits: bool = False
    behind: str = ""
    fired: int = 0
    again: int = 0
    firing: tuple[float, str, str] | None = None
    cause: tuple[float, str] | None = None
    latch: tuple[float, str] | None = None
    reading: str = ""
    parameters: Mapping[str, Any] = {}

    def after(self, event: RuleChanged, others: Mapping[str, RuleState]) -> RuleState:
        """The state after an event. A rule that fired stays active until its action has ended, even if released."""
        phase = event.phase
        fires = phase in ("fired", "fired again", "stopped")
        latch = (event.t, event.reading) if phase == "latched" else self.latch
        return RuleState(
            phase=phase,
            last=event.reading,
            priority=event.priority,
            latched=phase != "released" and (self.latched or phase in ("latched", "waits")),
            active=phase != "ended" and (self.active or phase in ("fired", "fired again")),
            waits=phase == "waits" or (self.waits and phase not in ("released", "fired")),
            behind=_fired_last(others) if phase == "waits" else self.behind,
            fired=self.fired + (phase == "fired"),
            again=event.refirings if fires else self.again,
            firing=(event.t, phase, event.reading) if fires else self.firing,
            cause=(latch or self.cause) if fires else self.cause,
            latch=latch,
            reading=event.reading or self.reading,
            parameters=event.parameters or self.parameters,
        )


class Failures(msgspec.Struct, frozen=True):
    """Failures of a rule's action in one activation of the rule.

    Attributes:
        count: Number of failures so far.
        first: Time of the first [s].
        text: All of it in words.
    """

    count: int
    first: float
    text: str

    @staticmethod
    def after(before: Failures | None, event: TicketChanged) -> Failures:
        """The failures after another one."""
        count, first = (1, event.t) if before is None else (before.count + 1, before.first)
        return Failures(count, first, failed_again(event.action, count, event.reason, f" since t = {first:.2f} s"))


def _fired_last(rules: Mapping[str, RuleState]) -> str:
    """The rule that fired last, of those that are active or latched; empty if there is none."""
    fired = {name: rule.firing[0] for name, rule in rules.items() if rule.firing and (rule.active or rule.latched)}
    return max(fired, key=lambda name: fired[name], default="")


class GuardState(msgspec.Struct, frozen=True, omit_defaults=True):
    """What keeps a rule from latching.

    Attributes:
        held: Comparisons of its guard that keep it from being true, the fewest that would have to change: the index of
            one that has to hold, -1 minus the index of one that must not.
        mode: Mode of the agent, in which the rule does not act; else None.
        since: Time from which its guard has counted as true [s].
        blind: Whether its guard counts as true because it cannot be evaluated.
        ready: End of its cooldown [s]; None if it is over.
        replaced: Whether its file was replaced, so that its guard is not recorded.
    """

    held: tuple[int, ...] = ()
    mode: str | None = None
    since: float | None = None
    blind: bool = False
    ready: float | None = None
    replaced: bool = False


class Drive(NamedTuple):
    """Commands of an agent's actuators at one time, with their cause."""

    route: str
    ticket: int  # of the action that ran; 0 if none did
    action: str
    neutral: bool  # whether all values are zero


def about(event: Event) -> TrackKey | None:
    """Track that an event is about, for links; None if there is none."""
    if isinstance(event, ActorMoved):
        return TrackKey(event.body, "actor")
    if isinstance(event, ScriptActed):
        return TrackKey(event.agent, event.topic, event.name)
    if isinstance(event, RuleChanged):
        return TrackKey(event.agent, "rule", event.rule)
    if isinstance(event, TicketChanged):
        return TrackKey(event.agent, "ticket", str(event.ticket))
    if isinstance(event, OutcomeDecided):
        return TrackKey(event.agent, "outcome")
    if isinstance(event, BlackboardChanged):
        return TrackKey(event.agent, "board", f"{event.subtree}\n{event.key}")
    if isinstance(event, SensorFailed):
        return TrackKey(event.agent, "sensor", event.sensor)
    if isinstance(event, MotionHeld | MotionReleased):
        return TrackKey(event.agent, "hold", event.actuator)
    node = event.content if isinstance(event, ContentRaised) and event.kind == "leaf" else getattr(event, "node", "")
    return TrackKey(event.agent, "node", node) if node else None


_UNSEEN: Mapping[type, Collection[str]] = {  # known otherwise, or not shown; there are many
    TicketChanged: {"event", "t", "agent"},
    RuleState: {"last", "latch", "priority"},
}


def plain_value(value: object) -> Any:
    """A value of a track as plain data, in the form that people see.

    Numbers have eight digits, and those that are not finite become texts.
    """
    plain, unseen = _finite(msgspec.to_builtins(value)), _UNSEEN.get(type(value))
    return {name: each for name, each in plain.items() if name not in unseen} if unseen else plain


def shown_number(value: float, digits: int) -> float | str:
    """A number with so many digits; one that is not finite as text."""
    if math.isfinite(value):
        return float(f"{value:.{digits}g}")
    return "NaN" if math.isnan(value) else "∞" if value > 0 else "−∞"


def _finite(value: Any) -> Any:
    if isinstance(value, float):
        return shown_number(value, 8)
    if isinstance(value, dict):
        return {name: _finite(inner) for name, inner in value.items()}
    return [_finite(inner) for inner in value] if isinstance(value, (list, tuple)) else value
