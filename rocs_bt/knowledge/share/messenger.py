"""Messages between minds: sent until they are acknowledged, taken once, and never waited for."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol, runtime_checkable

import msgspec

from ...errors import InputError
from .scope import agent_of
from .wire import TextAck, TextMessage

TEXT_LIMIT = 1024
"""[bytes] A longer message is refused by who would send it."""

QUEUE_LIMIT = 64
"""Messages that wait in a mailbox at most."""

READ_LIMIT = 8
"""Letters that a mailbox gives in one reading at most."""

RESEND_AFTER = 0.2
"""[s] After which a message that nobody acknowledged is sent again."""

ALL = "all"
"""The address of everybody."""

_REMEMBERED = 1024  # numbers of one sender


class ReceivedMessage(msgspec.Struct, frozen=True):
    """A message that arrived.

    Attributes:
        sender: The agent that sent it.
        text: What it says.
    """

    sender: str
    text: str


class MessageQueue:
    """What arrived and was not read yet; bounded, and safe under threads."""

    def __init__(self) -> None:
        self._messages: deque[ReceivedMessage] = deque()

    def put(self, message: ReceivedMessage) -> str:
        """Take a letter; or why not."""
        if len(self._messages) >= QUEUE_LIMIT:
            return "the mailbox is full"
        self._messages.append(message)
        return ""

    def take(self, most: int = READ_LIMIT) -> list[ReceivedMessage]:
        """The oldest messages, which are taken out."""
        return [self._messages.popleft() for _ in range(min(most, len(self._messages)))]


def packed(messages: Iterable[ReceivedMessage]) -> list[float]:
    """Letters as a sensor gives them: of each how many bytes its sender and its text have, and these bytes."""
    values: list[float] = []
    for message in messages:
        sender, text = message.sender.encode(), message.text.encode()
        values += (len(sender), len(text), *sender, *text)
    return list(map(float, values))


def unpacked(values: Sequence[float]) -> list[ReceivedMessage]:
    """The messages that `packed` made values of; what is no letter ends them."""
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
    """A sensor through which a mind reads its messages.

    Attributes:
        message_queue: Where they are put.
    """

    message_queue: MessageQueue


@dataclass
class Delivery:
    """What becomes of a message that was sent; read by the action that sent it.

    Attributes:
        to: The agents that it is for.
        text: What it says.
        heard: Those that acknowledged it.
        problems: By agent, why the last attempt was not taken.
        withdrawn: Whether its sender cares no more.
    """

    to: tuple[str, ...]
    text: str
    heard: set[str] = field(default_factory=set)
    problems: dict[str, str] = field(default_factory=dict)
    withdrawn: bool = False

    @property
    def missing(self) -> list[str]:
        """Those that did not acknowledge it, yet."""
        return [agent for agent in self.to if agent not in self.heard]

    @property
    def done(self) -> bool:
        """Whether everybody acknowledged it."""
        return not self.missing


class Messenger:
    """Sends an agent's messages and takes those for it.

    Args:
        agent: Whose.
        others: The agents that are there now.

    Attributes:
        message_queue: Where messages for it are put; None where the robot has no mailbox.
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
        """The agents that are there now, but for this one."""
        return [agent for agent in self._others() if agent != self.agent]

    def send(self, to: str, text: str) -> Delivery:
        """Send a message; it is on its way when the next turn of sharing comes.

        Args:
            to: An agent, or `all` that are there.
            text: What it says.

        Raises:
            InputError: The text is too long.
        """
        if (size := len(text.encode())) > TEXT_LIMIT:
            raise InputError(f"a message has at most {TEXT_LIMIT} bytes, found {size}. Say it in fewer words.")
        delivery = Delivery(tuple(self.others()) if to == ALL else (to,), text)
        with self._lock:
            self._number += 1
            self._open[self._number], self._due[self._number] = delivery, 0.0
        return delivery

    @property
    def pending(self) -> bool:
        """Whether a message is on its way."""
        return bool(self._open)

    def outgoing(self, t: float, starts: Mapping[str, str]) -> list[tuple[str, TextMessage]]:
        """What is to be sent now, each with its peer.

        Args:
            t: Now [s].
            starts: By agent that is there, its peer.
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

    def said(self, sender: str, message: TextMessage) -> TextAck:
        """Take a message, once however often it comes; the answer to its sender."""
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

    def heard(self, sender: str, message: TextAck) -> None:
        """Note what became of a message of ours."""
        with self._lock:
            delivery = self._open.get(message.number)
        agent = agent_of(sender)
        if delivery is None or agent not in delivery.to:
            return
        if message.problem:
            delivery.problems[agent] = message.problem
        else:
            delivery.heard.add(agent)
            delivery.problems.pop(agent, None)

    def gone(self, peer: str) -> None:
        """A start of a peer is over for good: its numbers will not come again."""
        self._taken.pop(peer, None)
