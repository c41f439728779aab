"""Reflex arc: chooses the one active reflex of an agent (docs/architecture.md; paper, 4.3).

The arc has a single slot for the active reflex. A reflex is active from firing until its action has ended and its rule
is released. Meanwhile, actions of priority NORMAL, which are those of the plan, wait. A rule with strictly higher
priority takes over the slot. Every other latched rule waits, and starts only if it is still latched when the slot is
free.
"""

from __future__ import annotations

import math
import threading
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..actions.stop import Stop
from ..base.clock import Clock
from ..base.errors import InputError, interrupts
from ..base.raised import Raised, from_actuator
from ..base.words import failed_again
from ..event import EventSink, RuleChanged, Value
from ..interfaces.action import Action, Failure, InvalidAction, Reason, make_action
from ..interfaces.pipeline import Pipeline, Priority, Ticket
from .reactive_model import ReactiveModel, Reflex
from .rule_model import RuleModel

OVERTAKEN = 0.5  # [s]; a snapshot up to this much older than the last is late (threads), else time was reset
MATERIAL = 0.05  # minimum relative change of a parameter for which an event is emitted


class _Active:
    """Active reflex, which occupies the slot of the arc.

    `stopping` is True if the action raised an exception: Stop then replaces the action until the rule is released.
    """

    __slots__ = ("reflex", "reported", "stopping", "ticket")

    def __init__(self, reflex: Reflex, ticket: Ticket, *, stopping: bool = False) -> None:
        self.reflex = reflex
        self.ticket = ticket
        self.reported = reflex.parameters
        self.stopping = stopping


class ReflexArc:
    """Evaluates the reactive models of an agent on each snapshot and runs their reflexes; thread-safe.

    Args:
        models: Reactive models.
        pipeline: Pipeline that executes the actions; it holds back NORMAL actions while a reflex is active.
        actions: Actions of the agent, keyed by name.
        sink: Sink that receives the RuleChanged events.
        agent: Name of the agent, for the events.
        clock: Clock of the events.

    Attributes:
        on_end: Called with the name of the last active rule when the slot becomes free, outside the arc's lock. The
            agent uses it to continue the plan from the present state.
        on_exception: Handler of exceptions that reactive models and actions of reflexes raise; None to raise them.
        activations: Number of activations of each rule, without re-firings.
        refirings: Number of times that each rule fired again because its action had ended while the rule was latched.
        switches: Number of switches between the deliberative route (plan) and the reactive route (reflexes).
    """

    def __init__(
        self,
        models: Sequence[ReactiveModel],
        pipeline: Pipeline,
        actions: Mapping[str, type[Action]],
        sink: EventSink,
        agent: str,
        clock: Clock,
    ) -> None:
        self.on_end: Callable[[str], None] = lambda rule: None
        self.on_exception: Callable[[Raised], None] | None = None
        self.activations: Counter[str] = Counter()
        self.refirings: Counter[str] = Counter()
        self.switches = 0
        self._models = models  # not a copy: a mission may add models to Knowledge
        self._pipeline = pipeline
        self._actions = actions
        self._sink = sink
        self._agent = agent
        self._clock = clock
        self._lock = threading.RLock()  # each Monitor runs the rules on the thread of its own samples
        self._slot: _Active | None = None
        self._wanted: dict[str, Reflex] = {}
        self._waiting: set[str] = set()
        self._readings: dict[str, str] = {}
        self._planned: set[str] = set()  # rules that wait for something outside of the robot
        self._ranks: dict[str, int] = {}  # highest priority that each model in Python has requested
        self._again: Counter[str] = Counter()  # re-firings of each rule's present activation
        self._failed: dict[str, tuple[int, Ticket | None]] = {}  # `_failures` of each rule, before its present action
        self._t = -math.inf

    @property
    def active(self) -> str | None:
        """Name of the active rule; None while no reflex is active."""
        slot = self._slot
        return slot.reflex.rule if slot else None

    @property
    def waiting(self) -> bool:
        """Whether the active rule waits for something outside of the robot."""
        slot = self._slot
        return slot is not None and self.waits(slot.reflex.rule)

    def waits(self, rule: str) -> bool:
        """Whether a rule that has fired waits for something outside of the robot, such as a person."""
        return rule in self._planned

    def reading(self, rule: str) -> str:
        """Guard values of a rule when it last fired, such as `min(front) = 0.21 m`; empty if it never fired.

        The failures of its action follow, if there was more than one in its last activation.
        """
        text, (count, last) = self._readings.get(rule, ""), self._failures(rule)
        if last is None or count < 2:
            return text
        return "; ".join(filter(None, [text, failed_again(last.action.name, count, str(last.failure))]))

    def _failures(self, rule: str) -> tuple[int, Ticket | None]:
        """Number of failures of a rule's action in its last activation, and the last failed ticket."""
        (count, last), slot = self._failed.get(rule, (0, None)), self._slot
        fails = slot is not None and slot.reflex.rule == rule and slot.ticket.failure is not None
        return (count + 1, slot.ticket) if slot is not None and fails else (count, last)

    def run(self, x: NDArray[np.float64], t: float) -> None:
        """Evaluate all models on a new snapshot, then choose and update the active reflex.

        Args:
            x: Snapshot of all signals, SI units, shape (size,).
            t: Time of the snapshot [s].
        """
        with self._lock:
            if self._t - OVERTAKEN <= t < self._t:
                return
            self._t = t
            reflexes = [reflex for model in self._models for reflex in self._react(model, x, t)]
            if not reflexes and not self._wanted and self._slot is None:
                return
            self._latch(reflexes)
            ended = self._settle()
        if ended is not None:
            self.on_end(ended)

    def _react(self, model: ReactiveModel, x: NDArray[np.float64], t: float) -> Sequence[Reflex]:
        """Reflexes of a model; if a user's model raises an exception, Stop with the model's highest priority so far."""
        if isinstance(model, RuleModel):  # engine code: its exception ends the run
            return model.react(x, t)
        try:
            reflexes = [_checked(reflex) for reflex in model.react(x, t)]
        except BaseException as error:  # content may raise anything
            if interrupts(error):
                raise
            if self.on_exception is None or from_actuator(error):
                raise
            name = type(model).__name__
            raised = Raised.of("reactive model", name, error, type(model).react)
            if (rule := f"{name}/Raised") not in self._wanted:
                self.on_exception(raised)
            return [Reflex(rule, self._ranks.get(name, 0), "Stop", broken=True, reading=str(raised))]
        if reflexes:
            name, rank = type(model).__name__, max(reflex.priority for reflex in reflexes)
            self._ranks[name] = max(rank, self._ranks.get(name, rank))
        return reflexes

    def _latch(self, reflexes: Sequence[Reflex]) -> None:
        """Update the set of latched rules and emit an event for each rule that was latched or released."""
        before, self._wanted = self._wanted, {r.rule: r for r in reflexes if r.latched}
        readings = {r.rule: r for r in reflexes if not r.latched}
        for rule, reflex in before.items():
            if rule not in self._wanted:
                self._waiting.discard(rule)
                self._emit(readings.get(rule, reflex), "released", reading=rule in readings)
                if (slot := self._slot) and slot.reflex.rule == rule and (reflex.level or slot.stopping):
                    self._pipeline.cancel(slot.ticket, by=rule)
        for rule, reflex in self._wanted.items():
            if rule not in before:
                self._emit(reflex, "latched")

    def _settle(self) -> str | None:
        """Choose the active reflex.

        Returns:
            Name of the rule that was active before, if now none is; else None.
        """
        before = self.active
        self._arbitrate()
        for rule, reflex in self._wanted.items():
            if rule != self.active and rule not in self._waiting:
                self._waiting.add(rule)
                self._emit(reflex, "waits")
        if (before is None) != (self.active is None):
            self.switches += 1
        if before is None or self.active is not None:
            return None
        self._pipeline.hold(False)
        return before

    def _arbitrate(self) -> None:
        # The order of the cases matters: a rule of higher priority takes over even if the action of the active one has
        # just ended, and an active rule that is still latched fires again before any rule that waits.
        slot = self._slot
        best = max(self._wanted.values(), key=lambda r: r.priority, default=None)
        if slot is None:
            if best is not None:
                self._start(best)
        elif best is not None and best.rule != slot.reflex.rule and best.priority > slot.reflex.priority:
            self._start(best)
            # Submit before cancelling, so that there is always an action to execute.
            self._pipeline.cancel(slot.ticket, by=best.rule)
            self._end(slot.reflex)
        elif slot.reflex.rule in self._wanted:
            self._continue(slot, self._wanted[slot.reflex.rule])
        elif slot.ticket.state.done:
            self._end(slot.reflex)
            self._slot = None
            if best is not None:
                self._start(best)

    def _start(self, reflex: Reflex) -> None:
        """Make a reflex the active one, possibly in place of another."""
        self._pipeline.hold(True, reflex.rule)
        self._waiting.discard(reflex.rule)
        self._failed.pop(reflex.rule, None)
        self.activations[reflex.rule] += 1
        self._slot = self._fire(reflex, "fired")

    def _end(self, reflex: Reflex) -> None:
        """Emit the end of a rule's activation."""
        self._failed[reflex.rule] = self._failures(reflex.rule)
        self._emit(reflex, "ended", reading=False)
        del self._again[reflex.rule]

    def _continue(self, slot: _Active, own: Reflex) -> None:
        """Continue the active rule, still latched: update its action, or fire again if the action has ended."""
        if slot.stopping:
            return
        if (failure := slot.ticket.failure) is not None and failure.reason is Reason.RAISED:
            self._slot = self._stop(own)
            return
        if slot.ticket.state.done:
            self._failed[own.rule] = self._failures(own.rule)
            self.refirings[own.rule] += 1
            self._again[own.rule] += 1
            self._slot = self._fire(own, "fired again")
            return
        if own.parameters != slot.reflex.parameters:
            try:
                slot.ticket.action.update(**own.parameters)
            except InputError as error:
                self._fail(slot, Failure.cannot(error))
            except BaseException as error:  # content may raise anything
                if interrupts(error):
                    raise
                self._fail(slot, self._raised(slot.ticket.action, error))
        slot.reflex = own
        if _material(slot.reported, own.parameters):
            slot.reported = own.parameters
            self._emit(own, "updated")

    def _fire(self, reflex: Reflex, phase: str) -> _Active:
        if reflex.waits_for:
            self._planned.add(reflex.rule)
        else:
            self._planned.discard(reflex.rule)
        self._readings[reflex.rule] = reflex.describe()
        self._emit(reflex, phase)
        if reflex.broken:
            return self._stop(reflex)
        action: Action
        try:
            action = make_action(self._actions, reflex.action, reflex.parameters)
        except InputError as error:  # an invalid action must stop the robot; the arc continues
            action = InvalidAction(reflex.action, reflex.parameters, error)
        except BaseException as error:  # content may raise anything
            if interrupts(error):
                raise
            self._raised(self._actions[reflex.action], error)
            return self._stop(reflex)
        return _Active(reflex, self._pipeline.submit(action, Priority.HIGH, by=reflex.rule))

    def _stop(self, reflex: Reflex) -> _Active:
        """Submit Stop in place of an action that raised. A new instance of the action would raise in every period."""
        self._emit(reflex, "stopped")
        return _Active(reflex, self._pipeline.submit(Stop(), Priority.HIGH, by=reflex.rule), stopping=True)

    def _fail(self, slot: _Active, failure: Failure) -> None:
        self._pipeline.fail(slot.ticket, failure)
        self._pipeline.wake()

    def _raised(self, action: Action | type[Action], error: BaseException) -> Failure:
        """Report an exception of a reflex's action to `on_exception`; raise it if there is no handler."""
        if self.on_exception is None:
            raise error
        name = action.__name__ if isinstance(action, type) else action.name
        raised = Raised.of("reflex action", name, error, action)
        self.on_exception(raised)
        return Failure(Reason.RAISED, str(raised))

    def _emit(self, reflex: Reflex, phase: str, reading: bool = True) -> None:
        self._sink.emit(
            RuleChanged(
                t=self._clock.now(),
                agent=self._agent,
                rule=reflex.rule,
                phase=phase,
                priority=reflex.priority,
                reading=reflex.describe() if reading else "",
                parameters=reflex.parameters,
                refirings=self._again[reflex.rule],
            )
        )


def _checked(reflex: Any) -> Reflex:
    """Check that an item returned by a user's model is a Reflex; raises TypeError."""
    if not isinstance(reflex, Reflex):
        raise TypeError(f"react must return a list of Reflex, found an item {reflex!r:.60}")
    return reflex


def _material(before: Mapping[str, Value], now: Mapping[str, Value]) -> bool:
    """Whether any parameter changed by enough for an event."""
    return any(_differs(before.get(name), value) for name, value in now.items())


def _differs(before: Any, now: Any) -> bool:
    if isinstance(before, float) and isinstance(now, float):
        return abs(now - before) > MATERIAL * max(abs(now), abs(before))
    if isinstance(before, list) and isinstance(now, list):
        return len(before) != len(now) or any(map(_differs, before, now))
    return bool(before != now)
