"""Text messages between agents: sent without blocking, resent until acknowledged, delivered only once."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Mapping

from ..base.errors import InputError
from ..interfaces.message import ALL, Delivery, MessageQueue, ReceivedMessage
from .scope import agent_of
from .wire import TextAck, TextMessage

TEXT_LIMIT = 1024
"""Maximum size of a message [bytes]; the sender refuses longer ones."""

RESEND_AFTER = 0.2
"""Time after which an unacknowledged message is sent again [s]."""

_REMEMBERED = 1024  # how many message numbers are remembered for each sender, to detect repetitions


class GroupMessenger:
    """Sends and receives the text messages of one agent, as `interfaces.message.Messenger`.

    Attributes:
        message_queue: Queue of received messages; None if the robot has no mailbox.
    """

    def __init__(self, agent: str, others: Callable[[], Iterable[str]]) -> None:
        self.agent = agent
        self.message_queue: MessageQueue | None = None
        self._others = others
        self._lock = threading.Lock()
        self._number = 0
        self._open: dict[int, Delivery] = {}
        self._due: dict[int, float] = {}
        self._taken: dict[str, dict[int, None]] = {}

    def others(self) -> list[str]:
        """The other agents that are present."""
        return [agent for agent in self._others() if agent != self.agent]

    def send(self, to: str, text: str) -> Delivery:
        """Queue a message, which is sent with the next turn of sharing.

        Args:
            to: Receiving agent, or `all` for all agents that are present.
            text: Text of the message.

        Raises:
            InputError: The text is too long.
        """
        if (size := len(text.encode())) > TEXT_LIMIT:
            raise InputError(f"a message has at most {TEXT_LIMIT} bytes, found {size}. Shorten the text.")
        delivery = Delivery(tuple(self.others()) if to == ALL else (to,), text)
        with self._lock:
            self._number += 1
            self._open[self._number], self._due[self._number] = delivery, 0.0
        return delivery

    @property
    def pending(self) -> bool:
        """Whether a message has not been acknowledged by all its receivers."""
        return bool(self._open)

    def outgoing(self, t: float, starts: Mapping[str, str]) -> list[tuple[str, TextMessage]]:
        """Messages to send now, each with the origin (`agent#start`) of its receiver.

        Args:
            t: Present time [s].
            starts: Newest origin of each agent that is present, by agent.
        """
        found = []
        with self._lock:
            for number, delivery in list(self._open.items()):
                if delivery.withdrawn or delivery.done:
                    del self._open[number], self._due[number]
                elif t >= self._due[number]:
                    self._due[number] = t + RESEND_AFTER
                    say = TextMessage(number, delivery.text)
                    found += [(starts[agent], say) for agent in delivery.missing if agent in starts]
        return found

    def receive(self, sender: str, message: TextMessage) -> TextAck:
        """Receive a message, ignoring repetitions; returns the acknowledgement for its sender."""
        taken = self._taken.setdefault(sender, {})
        if message.number in taken:
            return TextAck(message.number, "")
        if self.message_queue is None:
            return TextAck(message.number, f"'{self.agent}' has no mailbox")
        if len(message.text.encode()) > TEXT_LIMIT:
            return TextAck(message.number, "the message is too long")
        problem = self.message_queue.put(ReceivedMessage(agent_of(sender), message.text))
        if not problem:
            taken[message.number] = None
            if len(taken) > _REMEMBERED:
                del taken[next(iter(taken))]
        return TextAck(message.number, problem)

    def acknowledge(self, sender: str, message: TextAck) -> None:
        """Process the acknowledgement of a sent message."""
        with self._lock:
            delivery = self._open.get(message.number)
        agent = agent_of(sender)
        if delivery is None or agent not in delivery.to:
            return
        if message.problem:
            delivery.problems[agent] = message.problem
        else:
            delivery.acknowledged.add(agent)
            delivery.problems.pop(agent, None)

    def forget(self, peer: str) -> None:
        """Forget the messages received from an origin (`agent#start`) that is gone; it cannot return."""
        self._taken.pop(peer, None)
