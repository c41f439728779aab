"""Text messages between robots: those received, the delivery of those sent, and the mailbox of a robot."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Protocol, runtime_checkable

import msgspec

QUEUE_LIMIT = 64
"""Maximum number of messages in a mailbox."""

READ_LIMIT = 8
"""Maximum number of messages taken from a mailbox at once."""

ALL = "all"
"""Address of all agents."""


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


class Messenger(Protocol):
    """Sends the text messages of one agent, and puts those that arrive into its queue.

    Attributes:
        message_queue: Queue of received messages; None if the robot has no mailbox.
    """

    message_queue: MessageQueue | None

    def others(self) -> list[str]:
        """The other agents that are present."""

    def send(self, to: str, text: str) -> Delivery:
        """Queue a message for an agent, or for `all` that are present.

        Raises:
            InputError: The text is too long.
        """
