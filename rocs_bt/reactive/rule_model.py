"""RuleModel: a rule file as a ReactiveModel.

A rule's life. *Open*: when its guard has held for `for`, and no cooldown runs, it latches, which is when it wants its
action. *Latched*: `until` decides alone (hysteresis), and releases it. All rules advance on every snapshot, whichever
of them acts. Time is the snapshots' own; where it goes backwards everything begins anew.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from ..expression import joint_function, reading
from .reactive_model import ReactiveModel, Reflex
from .rule import OnInvalid, Rule, RuleSet

_TOLERANCE = 1e-9  # [s]; periods such as 0.05 s have no exact sums


class _State:
    """Where one rule is in its life."""

    __slots__ = ("blind_since", "latched", "ready", "risen")

    def __init__(self) -> None:
        self.latched = False
        self.risen: float | None = None  # since when the guard holds [s]
        self.ready = -math.inf  # when the cooldown is over [s]
        self.blind_since: float | None = None  # since when the guard is invalid [s]

    @property
    def resting(self) -> bool:
        """Whether a guard that does not hold changes nothing here."""
        return not self.latched and self.risen is None and self.blind_since is None


class RuleModel(ReactiveModel):
    """The reflexes of one rule file.

    Args:
        rules: From `load_rules`.
    """

    def __init__(self, rules: RuleSet) -> None:
        self.rules = rules
        self._guards = joint_function([rule.when.node for rule in rules.rules])
        self.reset()

    @property
    def name(self) -> str:
        return self.rules.name

    @property
    def latched(self) -> tuple[str, ...]:
        """The rules that are latched."""
        return tuple(r.name for r, s in zip(self.rules.rules, self._states, strict=True) if s.latched)

    def reset(self) -> None:
        """Forget everything, as at the beginning of an episode."""
        self._states = [_State() for _ in self.rules.rules]
        self._awake = False
        self._t = -math.inf

    def react(self, x: NDArray[np.float64], t: float) -> Sequence[Reflex]:
        if t < self._t:
            self.reset()
        self._t = t
        values = x.tolist()
        guards = self._guards(values)
        if not self._awake and not any(guards) and None not in guards:
            return ()
        wanted = []
        for rule, state, guard in zip(self.rules.rules, self._states, guards, strict=True):
            if guard is False and state.resting:
                continue
            was = state.latched
            decided = guard if not was else _release(rule, guard, values)
            _advance(rule, state, decided, t)
            if was or state.latched:
                wanted.append(_reflex(rule, state.latched, values, blind=guard is None or decided is None))
        self._awake = not all(state.resting for state in self._states)
        return wanted


def _release(rule: Rule, guard: float | bool | None, values: Sequence[float]) -> float | bool | None:
    """Whether a latched rule is released; None where that cannot be known."""
    if rule.until is not None:
        return rule.until.function(values)
    return None if guard is None else not guard


def _advance(rule: Rule, state: _State, decided: float | bool | None, t: float) -> None:
    if decided is None:
        if state.blind_since is None:
            state.blind_since = t
        meaning = rule.on_invalid
        if meaning is OnInvalid.HOLD:
            if t - state.blind_since < rule.max_hold - _TOLERANCE:
                return
            meaning = OnInvalid.TRIP
        decided = (meaning is OnInvalid.TRIP) is not state.latched
    else:
        state.blind_since = None
    if state.latched:
        if decided:
            state.latched = False
            if rule.level:
                state.ready = t + rule.cooldown
    elif not decided:
        state.risen = None
    else:
        _rise(rule, state, t)


def _rise(rule: Rule, state: _State, t: float) -> None:
    """The guard of an open rule holds."""
    if state.risen is None:
        state.risen = t
    if t - state.risen >= rule.hold - _TOLERANCE and t >= state.ready - _TOLERANCE:
        state.latched, state.risen = True, None
        if not rule.level:
            state.ready = t + rule.cooldown


def _reflex(rule: Rule, latched: bool, values: Sequence[float], blind: bool) -> Reflex:
    return Reflex(
        rule=rule.name,
        priority=rule.priority,
        action=rule.action,
        parameters=rule.parameters(values, blind) if latched else {},
        level=rule.level,
        latched=latched,
        reading=_describe(rule, latched, values),
    )


def _describe(rule: Rule, latched: bool, values: Sequence[float]) -> Callable[[], str]:
    node = rule.when.node if latched or rule.until is None else rule.until.node
    return lambda: reading(node, values)
