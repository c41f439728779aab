"""SendMessage: send a text to other robots (paper, 4.2: outgoing messages belong to Execute)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..base.units import PositiveSeconds
from ..interfaces.action import AtomicAction, Body, Failure, Progress, Reason
from ..interfaces.message import ALL, Delivery


class SendMessage(AtomicAction):
    """Send a text to one robot, or to all present ones, with acknowledgement.

    The message is repeated until each receiver has acknowledged it; it is delivered to each mailbox once. While the
    action is RUNNING it commands nothing, so the robot is stationary. It fails with UNHEARD if no other robot is
    present, or if a receiver does not acknowledge in time; the other receivers keep the message.

    Attributes:
        text: Message, at most 1024 bytes.
        to: Name of the receiver, or `all`.
        patience: Time limit for all acknowledgements [s].
    """

    text: str
    to: str = "all"
    patience: PositiveSeconds = 2.0
    _delivery: Delivery | None = None
    _since: float | None = None

    @classmethod
    def can_move(cls, parameters: Mapping[str, Any]) -> bool:
        return False

    def act(self, body: Body) -> Progress | Failure:
        now, messenger = body.clock.now(), body.messenger
        if messenger is None:
            return Failure(Reason.CANNOT, "the robot cannot send messages; add a [share] table to the scenario")
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
            return Failure(Reason.UNHEARD, f"no other robot was present in {waited:.1f} s")
        sent.withdrawn = True
        why = [f"{agent} did not acknowledge ({sent.problems.get(agent, 'no answer')})" for agent in sent.missing]
        here = ", ".join(messenger.others()) or "none"
        return Failure(Reason.UNHEARD, f"{'; '.join(why)} in {waited:.1f} s; present robots: {here}")

    def stop(self, body: Body) -> None:
        if self._delivery is not None:
            self._delivery.withdrawn = True
