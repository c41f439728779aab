"""SendMessage: tell other robots something (paper, 4.2: Execute owns what goes out)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from ..action import AtomicAction, Body, Failure, Progress, Reason
from ..knowledge.share import ALL, Delivery
from ..units import PositiveSeconds


@dataclass(kw_only=True, eq=False)
class SendMessage(AtomicAction):
    """Send a text to a robot, or to all that are there, and see that it arrived.

    It is sent again until its receivers have acknowledged that it lies in their mailboxes, in each once. Meanwhile the
    action is RUNNING and commands nothing, so that the robot stands. It fails with UNHEARD where nobody is there, or
    somebody has not acknowledged it in time; those that did have it all the same.

    Attributes:
        text: What to say; at most 1024 bytes.
        to: The robot, or `all`.
        patience: How long to wait for acknowledgements [s].
    """

    text: str
    to: str = "all"
    patience: PositiveSeconds = 2.0
    _delivery: Delivery | None = field(default=None, init=False, repr=False)
    _since: float | None = field(default=None, init=False, repr=False)

    @classmethod
    def can_move(cls, parameters: Mapping[str, Any]) -> bool:
        return False

    def act(self, body: Body) -> Progress | Failure:
        now, messenger = body.clock.now(), body.messenger
        if messenger is None:
            return Failure(Reason.CANNOT, "the robot shares nothing; the scenario needs a [share] table")
        self._since = now if self._since is None else self._since
        waited = now - self._since
        if self._delivery is None and (self.to != ALL or messenger.others()):
            self._delivery = messenger.send(self.to, self.text)
        sent = self._delivery
        if sent is not None and sent.done:
            return Progress.SUCCEEDED
        if waited < self.patience:
            return Progress.RUNNING
        if sent is None:
            return Failure(Reason.UNHEARD, f"nobody else was there in {waited:.1f} s")
        sent.withdrawn = True
        why = [f"{agent} did not acknowledge ({sent.problems.get(agent, 'no answer')})" for agent in sent.missing]
        here = ", ".join(messenger.others()) or "nobody"
        return Failure(Reason.UNHEARD, f"{'; '.join(why)} in {waited:.1f} s; there are: {here}")

    def stop(self, body: Body) -> None:
        if self._delivery is not None:
            self._delivery.withdrawn = True
