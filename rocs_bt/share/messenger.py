"""Text messages between agents: sent without blocking, resent until acknowledged, delivered only once."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol, runtime_checkable

import msgspec

from ..base.errors import InputError
from .scope import agent_of
from .wire import TextAck, TextMessage

TEXT_LIMIT = 1024
"""Maximum size of a message [bytes]; the sender refuses longer ones."""

QUEUE_LIMIT = 64
"""Maximum number of messages in a mailbox."""

READ_LIMIT = 8
"""Maximum number of messages taken from a mailbox at once."""

RESEND_AFTER = 0.2
"""Time after which an unacknowledged message is sent again [s]."""

ALL = "all"
"""Address of all agents."""

_REMEMBERED = 1024  # how many message numbers are remembered for each sender, to detect repetitions


class ReceivedMessage(msgspec.Struct, frozen=True):
    """Received text message.

    Attributes:
        sender: Agent that sent it.
        text: Text of the message.
    """

    sender: str
    text: str


class MessageQueue:
    """Bounded, thread-safe queue of received messages that have not been read."""

    def __init__(self) -> None:
        self._messages: deque[ReceivedMessage] = deque()

    def put(self, message: ReceivedMessage) -> str:
        """Add a message; returns the reason if it is rejected, or an empty string."""
        if len(self._messages) >= QUEUE_LIMIT:
            return "the mailbox is full"
        self._messages.append(message)
        return ""

    def take(self, most: int = READ_LIMIT) -> list[ReceivedMessage]:
        """Remove and return the oldest messages, `most` at most."""
        return [self._messages.popleft() for _ in range(min(most, len(self._messages)))]


def packed(messages: Iterable[ReceivedMessage]) -> list[float]:
    """Encode messages as sensor values: for each, the byte counts of its sender and text, and these bytes."""
    values: list[float] = []
    for message in messages:
        sender, text = message.sender.encode(), message.text.encode()
        values += (len(sender), len(text), *sender, *text)
    return list(map(float, values))


def unpacked(values: Sequence[float]) -> list[ReceivedMessage]:
    """Decode the messages that `packed` encoded; stops at a malformed one."""
    messages, at = [], 0
    try:
        whole = [int(value) for value in values]
        while at < len(whole):
            sender, text = whole[at : at + 2]
            end = at + 2 + sender
            if min(sender, text) < 0 or end + text > len(whole):
                break
            messages.append(
                ReceivedMessage(bytes(whole[at + 2 : end]).decode(), bytes(whole[end : end + text]).decode())
            )
            at = end + text
    except (ValueError, OverflowError):
        pass
    return messages


@runtime_checkable
class Mailbox(Protocol):
    """Sensor through which a robot receives text messages.

    Attributes:
        message_queue: Queue of received messages.
    """

    message_queue: MessageQueue


@dataclass
class Delivery:
    """Delivery state of a sent message, read by the action that sent it.

    Attributes:
        to: Receiving agents.
        text: Text of the message.
        acknowledged: Agents that have acknowledged the message.
        problems: Reason of the last rejection, by rejecting agent.
        withdrawn: Whether the sender has given up; set by the action that sent the message.
    """

    to: tuple[str, ...]
    text: str
    acknowledged: set[str] = field(default_factory=set)
    problems: dict[str, str] = field(default_factory=dict)
    withdrawn: bool = False

    @property
    def missing(self) -> list[str]:
        """Receivers that have not acknowledged the message yet."""
        return [agent for agent in self.to if agent not in self.acknowledged]

    @property
    def done(self) -> bool:
        """Whether all receivers have acknowledged the message."""
        return not self.missing


class Messenger:
    """Sends and receives the text messages of one agent.

    Args:
        agent: Name of the agent.
        others: Returns the names of all agents that are present.

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
