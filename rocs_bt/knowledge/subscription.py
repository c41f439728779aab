"""Who hears of changes in the graph: in the order of revision, one at a time, never under the writer's lock."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import msgspec

from ..event import EventSink, KnowledgeChanged, SubscriberDetached

Callback: TypeAlias = Callable[[KnowledgeChanged], None]
WriteObserver: TypeAlias = Callable[[list[KnowledgeChanged]], None]


class Delivery(msgspec.Struct, frozen=True, gc=False):
    """A change and what subscriptions ask of it: the nodes it is about, their kinds, the relation if it is an edge."""

    change: KnowledgeChanged
    nodes: tuple[str, ...]
    kinds: tuple[str, ...]
    relation: str | None = None


@dataclass(frozen=True)
class SubscriberFailure:
    """A callback that raised, and was detached.

    Attributes:
        callback: Its qualified name.
        change: What it was told.
        error: What it raised.
    """

    callback: str
    change: KnowledgeChanged
    error: Exception


class Subscription:
    """One wish to hear of changes; `close` ends it.

    Attributes:
        active: Whether it still hears.
    """

    __slots__ = ("_callback", "_kind", "_node", "_relation", "_subscribers", "active")

    def __init__(
        self, subscribers: Subscribers, callback: Callback, kind: str | None, node: str | None, relation: str | None
    ) -> None:
        self._subscribers = subscribers
        self._callback = callback
        self._kind = kind
        self._node = node
        self._relation = relation
        self.active = True

    def close(self) -> None:
        """Hear no more; a second call changes nothing."""
        self.active = False
        self._subscribers.remove(self)

    def fits(self, nodes: tuple[str, ...], kinds: tuple[str, ...], relation: str | None) -> bool:
        """Whether every filter that was given fits a change."""
        return (
            (self._node is None or self._node in nodes)
            and (self._kind is None or self._kind in kinds)
            and (self._relation is None or self._relation == relation)
        )

    def hear(self, delivery: Delivery) -> None:
        """Call back if the change fits; one that raises is detached and the writer never notices."""
        if self.active and self.fits(delivery.nodes, delivery.kinds, delivery.relation):
            try:
                self._callback(delivery.change)
            except Exception as error:  # noqa: BLE001 - the documented boundary between a writer and those who listen
                self.close()
                self._subscribers.failed(_name(self._callback), delivery.change, error)


class Subscribers:
    """All subscriptions of one graph, and the changes that they were not told of yet.

    Args:
        sink: Where a detached subscriber is reported.
    """

    def __init__(self, sink: EventSink) -> None:
        self._sink = sink
        self.pending: deque[Delivery] = deque()
        self._telling = threading.Lock()
        self._changing = threading.Lock()
        # Replaced as a whole, never changed in place: `deliver` walks over it without a lock.
        self.all: tuple[Subscription, ...] = ()
        self.failures: list[SubscriberFailure] = []

    def add(self, callback: Callback, kind: str | None, node: str | None, relation: str | None) -> Subscription:
        """Tell this one too, after those that came before it."""
        subscription = Subscription(self, callback, kind, node, relation)
        with self._changing:
            self.all = (*self.all, subscription)
        return subscription

    def remove(self, subscription: Subscription) -> None:
        """Tell this one no more."""
        with self._changing:
            self.all = tuple(s for s in self.all if s is not subscription)

    def queue(
        self, change: KnowledgeChanged, nodes: tuple[str, ...], kinds: tuple[str, ...], relation: str | None = None
    ) -> None:
        """Keep a change until it can be told, if it fits anybody: nearly none does."""
        for subscription in self.all:
            if subscription.fits(nodes, kinds, relation):
                self.pending.append(Delivery(change, nodes, kinds, relation))
                return

    def deliver(self) -> None:
        """Tell every queued change. A write inside a callback, or one on another thread meanwhile, is told after it."""
        pending, telling = self.pending, self._telling
        # Whoever holds `_telling` may have looked at the queue just before ours came: hence the outer loop.
        while pending and telling.acquire(False):
            try:
                while pending:
                    delivery = pending.popleft()
                    for subscription in self.all:
                        subscription.hear(delivery)
            finally:
                telling.release()

    def failed(self, callback: str, change: KnowledgeChanged, error: Exception) -> None:
        """Report a callback that raised and was detached."""
        self.failures.append(SubscriberFailure(callback, change, error))
        detail = f"{type(error).__name__}: {error}"
        self._sink.emit(
            SubscriberDetached(
                t=change.t, agent=change.agent, callback=callback, revision=change.revision, detail=detail
            )
        )


class WriteObservers:
    """Who is handed every whole write as its changes, in order; one `held` block is one write.

    For what keeps or shares the graph and must see no half of a write. A observer is called under the writer's lock:
    it must be as quick as to put the list into a queue, and must not raise. All methods are called under that lock.
    """

    def __init__(self) -> None:
        self.all: tuple[WriteObserver, ...] = ()
        self._written: list[KnowledgeChanged] = []

    def add(self, observer: WriteObserver) -> None:
        """Hand writes to this one too."""
        self.all = (*self.all, observer)

    def remove(self, observer: WriteObserver) -> None:
        """Hand nothing more to this one."""
        self.all = tuple(f for f in self.all if f != observer)

    def note(self, change: KnowledgeChanged) -> None:
        """A part of the write in progress."""
        self._written.append(change)

    def settle(self) -> None:
        """The write in progress is whole."""
        if self._written:
            written, self._written = self._written, []
            for observer in self.all:
                observer(written)


def _name(callback: Callback) -> str:
    return getattr(callback, "__qualname__", type(callback).__qualname__)
