"""Leaves that always come to the same."""

from __future__ import annotations

from ...status import FAILURE, SUCCESS, Outcome
from ..family import Instant


class AlwaysSuccess(Instant):
    """SUCCESS."""

    def tick_once(self) -> Outcome:
        self.status = SUCCESS
        return SUCCESS

    def update(self) -> Outcome:
        return SUCCESS


class AlwaysFailure(Instant):
    """FAILURE."""

    def tick_once(self) -> Outcome:
        self.status = FAILURE
        return FAILURE

    def update(self) -> Outcome:
        return FAILURE
