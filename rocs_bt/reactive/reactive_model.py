"""The ReactiveModel: a known deterministic mapping from what is sensed to an action (paper, 5.1 and 5.3)."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..raised import Raised


@dataclass(frozen=True)
class Reflex:
    """One rule that wants its action now; told anew for every snapshot as long as it wants it.

    Attributes:
        rule: Whose wish it is, unique in the agent, such as `avoid_collision/Flinch`.
        priority: A strictly higher one pre-empts.
        action: The action's name in the agent's action table.
        parameters: The action's parameters, SI units, from this snapshot.
        level: True: the action is cancelled when the wish ends. False: it runs to its own end.
        latched: False tells that the wish has ended, with the reading that ended it; leaving a rule out says the same.
        reading: What was seen, such as `min(front) = 0.21 m`, or a function that builds it, called only for events.
        broken: Whether it stands for a model that raised: Stop in place of an action until it no longer raises.
    """

    rule: str
    priority: int
    action: str
    parameters: Mapping[str, Any] = field(default_factory=dict)
    level: bool = False
    latched: bool = True
    reading: str | Callable[[], str] = ""
    broken: bool = False

    def describe(self) -> str:
        """What was seen, in words."""
        return self._described

    @cached_property
    def _described(self) -> str:  # once, for as many events as tell it
        if isinstance(self.reading, str):
            return self.reading
        try:
            return str(self.reading())
        except Exception as error:  # noqa: BLE001 - a text for people must not keep a reflex from acting
            return str(Raised.of("reading", self.rule, error, self.reading))


class ReactiveModel(ABC):
    """One aspect of reactive behaviour, such as not to fall; an agent may have several.

    A user's own model needs one method, and gets what it reads from Knowledge in its constructor or from the snapshot:

        class DoNotFall(ReactiveModel):
            def react(self, x, t):
                if abs(x[self.tilt]) > 0.3:
                    return [Reflex("do_not_fall/Tilted", priority=100, action="Stop")]
                return []
    """

    @property
    def name(self) -> str:
        """What reports call it."""
        return type(self).__name__

    @abstractmethod
    def react(self, x: NDArray[np.float64], t: float) -> Sequence[Reflex]:
        """The reflexes that are wanted now. Called for every fresh snapshot; must not block.

        Args:
            x: The snapshot of all signals, (size,) in SI units, NaN where stale or invalid; not to be changed.
            t: The snapshot's time [s].
        """
