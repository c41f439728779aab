"""Decorators that tell another outcome than their child came to."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from ...status import FAILURE, IDLE, RUNNING, SKIPPED, SUCCESS, Outcome
from ..family import Decorator, strange


class _Mapping(Decorator):
    """Ticks the child and looks its outcome up; what is not in the table stays as it is."""

    table: ClassVar[Mapping[Outcome, Outcome]] = {}

    def tick_once(self) -> Outcome:
        self.status = RUNNING
        child: Any = self.decorated
        outcome = child.tick_once() or child.status
        if outcome is IDLE:
            raise strange(child, outcome)
        outcome = self.table.get(outcome, outcome)
        if outcome is not SKIPPED:
            self.status = outcome
        return outcome


class Inverter(_Mapping):
    """SUCCESS where the child fails, FAILURE where it succeeds."""

    table: ClassVar[Mapping[Outcome, Outcome]] = {SUCCESS: FAILURE, FAILURE: SUCCESS}


class ForceSuccess(_Mapping):
    """SUCCESS when the child has ended, whatever it came to."""

    table: ClassVar[Mapping[Outcome, Outcome]] = {FAILURE: SUCCESS}


class ForceFailure(_Mapping):
    """FAILURE when the child has ended, whatever it came to."""

    table: ClassVar[Mapping[Outcome, Outcome]] = {SUCCESS: FAILURE}


class KeepRunningUntilFailure(_Mapping):
    """Ticks the child again and again until it fails; RUNNING until then, also when it is skipped."""

    table: ClassVar[Mapping[Outcome, Outcome]] = {SUCCESS: RUNNING, SKIPPED: RUNNING}
