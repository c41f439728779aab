"""Oracle of the rule back ends: the rules' typed trees, evaluated over a history of all snapshots; slow on purpose."""

import math

import numpy as np

from rocs_bt.reactive.backend import SequentialBatch
from rocs_bt.reactive.rule import OnInvalid
from rocs_bt.reactive.rule_table import COLUMNS

from ..expression.trace import Trace

_TOLERANCE = 1e-9  # [s]


class ReferenceBackend(SequentialBatch):
    """Interprets the rules themselves; of the table it uses no more than the layout.

    Its state holds no history, so a machine that is restored to a state with temporal operations in use begins those
    anew.

    Args:
        rules: The rules that the table was lowered from.
    """

    name = "reference"

    def __init__(self, rules):
        self._rules = rules

    def machine(self, table):
        return ReferenceMachine(table, self._rules)


class _Life:
    """One rule's life."""

    def __init__(self, rule):
        self.rule = rule
        self.enabled = True
        self.begin()

    def begin(self):
        self.latched = False
        self.risen = None
        self.ready = -math.inf
        self.unknown = None
        self.blind = False

    def step(self, trace, t):
        if not self.enabled:
            self.risen, self.unknown, self.blind = None, None, False
            self._release(t)
            return
        guard = trace.value(self.rule.when.node)
        decided = self._decides(guard, trace)
        self.blind = guard is None or decided is None
        if decided is None:
            self.unknown = t if self.unknown is None else self.unknown
            if self.rule.on_invalid is OnInvalid.HOLD and t - self.unknown < self.rule.max_hold - _TOLERANCE:
                return
            danger = self.rule.on_invalid is not OnInvalid.CLEAR
            decided = danger if not self.latched else not danger
        else:
            self.unknown = None
        if self.latched:
            if decided:
                self._release(t)
        elif not decided:
            self.risen = None
        else:
            self._rise(t)

    def _decides(self, guard, trace):
        if not self.latched:
            return guard
        if self.rule.until is not None:
            return trace.value(self.rule.until.node)
        return None if guard is None else not guard

    def _rise(self, t):
        self.risen = t if self.risen is None else self.risen
        if t - self.risen >= self.rule.hold - _TOLERANCE and t >= self.ready - _TOLERANCE:
            self.latched, self.risen = True, None
            if not self.rule.level:
                self.ready = t + self.rule.cooldown

    def _release(self, t):
        if self.latched and self.rule.level:
            self.ready = t + self.rule.cooldown
        self.latched = False


class ReferenceMachine:
    """One robot's rules; see Machine."""

    def __init__(self, table, rules):
        self.table = table
        self._trace = Trace()
        self._lives = [_Life(rule) for rule in rules]
        self._time = -math.inf
        self._stepped = False

    @property
    def mask(self):
        """Which rules are latched."""
        return [life.latched for life in self._lives]

    @property
    def blind(self):
        """Where the guard, or what decided, was invalid."""
        return [life.blind for life in self._lives]

    @property
    def margins(self):
        """The guards' margins."""
        if not self._stepped or not self.table.margins.size:
            return [math.nan] * self.table.margins.size
        margins = [self._trace.margin(life.rule.when.node) for life in self._lives]
        return [math.nan if margin is None else margin for margin in margins]

    def step(self, x, t):
        """Advance every rule; see Machine."""
        if t < self._time:
            self._trace = Trace()
            for life in self._lives:
                life.begin()
        self._time, self._stepped = t, True
        self._trace.append(x.tolist(), t)
        for life in self._lives:
            life.step(self._trace, t)
        latched = [(life.rule.priority, -i) for i, life in enumerate(self._lives) if life.latched]
        return -max(latched)[1] if latched else -1

    def register(self, index):
        """A register of the program; of temporal nodes alone."""
        node = next(n for n, register in self.table.program.temporal.items() if register == index)
        value = self._trace.value(node)
        return math.nan if value is None else float(value)

    def values(self):
        """A copy of the state; its cells are as at first."""
        values = self.table.start()
        values[0] = self._time
        for i, life in enumerate(self._lives):
            told = {
                "latched": life.latched,
                "risen": math.inf if life.risen is None else life.risen,
                "ready": life.ready,
                "unknown": math.inf if life.unknown is None else life.unknown,
                "enabled": life.enabled,
                "blind": life.blind,
            }
            for column in COLUMNS:
                values[self.table.part(column)][i] = told[column]
        values[self.table.part("margin")] = self.margins
        return values

    def restore(self, values):
        """Go on from a state, without its history."""
        self._trace, self._stepped = Trace(), False
        self._time = float(values[0])
        columns = {column: values[self.table.part(column)].tolist() for column in COLUMNS}
        for i, life in enumerate(self._lives):
            life.latched, life.ready = bool(columns["latched"][i]), columns["ready"][i]
            life.risen = _time(columns["risen"][i])
            life.unknown = _time(columns["unknown"][i])
            life.enabled, life.blind = bool(columns["enabled"][i]), bool(columns["blind"][i])

    def enable(self, rule, on):
        """Let a rule live, or not."""
        self._lives[rule].enabled = on


def _time(value):
    return None if np.isinf(value) else value
