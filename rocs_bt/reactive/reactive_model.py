"""ReactiveModel: a known, deterministic mapping from signals to an action (paper, 5.1 and 5.3)."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..base.raised import Raised


@dataclass(frozen=True)
class Reflex:
    """Request of one rule for its action, returned for every snapshot on which the rule is latched.

    Attributes:
        rule: Name of the rule, unique in the agent, such as `avoid_collision/Flinch`.
        priority: Priority; a strictly higher one pre-empts.
        action: Name of the action in the agent's action table.
        parameters: Parameters of the action for this snapshot, SI units.
        level: Whether the action is cancelled when the rule is released; otherwise it runs to its own end.
        latched: Whether the rule is latched. A model may report a release with False, so that the event shows the
            `reading` that caused it. A rule that is no longer returned is released, too.
        reading: Text of the guard values, such as `min(front) = 0.21 m`, or a function that builds this text and is
            called only for events.
        waits_for: Condition outside of the robot that releases the rule, such as `a person`; empty for none.
        broken: Whether the model raised an exception. Stop then replaces `action`, until the model no longer raises.
    """

    rule: str
    priority: int
    action: str
    parameters: Mapping[str, Any] = field(default_factory=dict)
    level: bool = False
    latched: bool = True
    reading: str | Callable[[], str] = ""
    waits_for: str = ""
    broken: bool = False

    def describe(self) -> str:
        """Guard values as text."""
        return self._described

    @cached_property
    def _described(self) -> str:  # cached, because several events contain it
        if isinstance(self.reading, str):
            return self.reading
        try:
            return str(self.reading())
        except Exception as error:  # noqa: BLE001 - a failing text must not prevent the reflex
            return str(Raised.of("reading", self.rule, error, self.reading))


class ReactiveModel(ABC):
    """Base class of reactive models, one for each aspect of reactive behaviour, such as fall prevention.

    A user's model implements `react`. It reads the snapshot, or Knowledge if its constructor takes this argument:

        class DoNotFall(ReactiveModel):
            def react(self, x, t):
                if abs(x[self.tilt]) > 0.3:
                    return [Reflex("do_not_fall/Tilted", priority=100, action="Stop")]
                return []
    """

    @property
    def name(self) -> str:
        """Name of the model in reports."""
        return type(self).__name__

    @abstractmethod
    def react(self, x: NDArray[np.float64], t: float) -> Sequence[Reflex]:
        """Return the requested reflexes; called for every new snapshot, must not block.

        Args:
            x: Snapshot of all signals, SI units, NaN for stale or invalid values, read-only, shape (size,).
            t: Time of the snapshot [s].
        """
