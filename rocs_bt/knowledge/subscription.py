"""Subscriptions to changes of the graph: delivered in order of revision, one at a time, outside the writer's lock."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import msgspec

from ..event import EventSink, KnowledgeChanged, SubscriberDetached

Callback: TypeAlias = Callable[[KnowledgeChanged], None]


class QueuedChange(msgspec.Struct, frozen=True, gc=False):
    """Queued change, with the data that subscriptions filter by: its nodes, their kinds, and an edge's relation."""

    change: KnowledgeChanged
    nodes: tuple[str, ...]
    kinds: tuple[str, ...]
    relation: str | None = None


@dataclass(frozen=True)
class SubscriberFailure:
    """Record of a callback that raised and was detached.

    Attributes:
        callback: Qualified name of the callback.
        change: Change that it was called with.
        error: Exception that it raised.
    """

    callback: str
    change: KnowledgeChanged
    error: Exception


class Subscription:
    """Filtered subscription to changes; `close` ends it.

    Attributes:
        active: Whether the subscription still receives changes.
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
        """End the subscription; further calls have no effect."""
        self.active = False
        self._subscribers.remove(self)

    def fits(self, nodes: tuple[str, ...], kinds: tuple[str, ...], relation: str | None) -> bool:
        """Whether a change passes all filters."""
        return (
            (self._node is None or self._node in nodes)
            and (self._kind is None or self._kind in kinds)
            and (self._relation is None or self._relation == relation)
        )

    def notify(self, delivery: QueuedChange) -> None:
        """Call the callback if the change passes the filters; detach a callback that raises."""
        if self.active and self.fits(delivery.nodes, delivery.kinds, delivery.relation):
            try:
                self._callback(delivery.change)
            except Exception as error:  # noqa: BLE001 - the documented boundary between a writer and its subscribers
                self.close()
                self._subscribers.failed(_name(self._callback), delivery.change, error)


class Subscribers:
    """All subscriptions of one graph, and the changes not yet delivered to them."""

    def __init__(self, sink: EventSink) -> None:
        self._sink = sink
        self.pending: deque[QueuedChange] = deque()
        self._delivering = threading.Lock()
        self._changing = threading.Lock()
        # Replaced as a whole, never changed in place: `deliver` iterates over it without a lock.
        self.all: tuple[Subscription, ...] = ()
        self.failures: list[SubscriberFailure] = []

    def add(self, callback: Callback, kind: str | None, node: str | None, relation: str | None) -> Subscription:
        """Add a subscription; its callback is called after those of earlier subscriptions."""
        subscription = Subscription(self, callback, kind, node, relation)
        with self._changing:
            self.all = (*self.all, subscription)
        return subscription

    def remove(self, subscription: Subscription) -> None:
        """Remove a subscription."""
        with self._changing:
            self.all = tuple(s for s in self.all if s is not subscription)

    def queue(
        self, change: KnowledgeChanged, nodes: tuple[str, ...], kinds: tuple[str, ...], relation: str | None = None
    ) -> None:
        """Queue a change for delivery if it matches any subscription."""
        for subscription in self.all:
            if subscription.fits(nodes, kinds, relation):
                self.pending.append(QueuedChange(change, nodes, kinds, relation))
                return

    def deliver(self) -> None:
        """Deliver every queued change, including changes that callbacks or other threads make during the delivery."""
        pending, delivering = self.pending, self._delivering
        # The outer loop: another thread may have found the queue empty just before this thread's change was added.
        while pending and delivering.acquire(False):
            try:
                while pending:
                    delivery = pending.popleft()
                    for subscription in self.all:
                        subscription.notify(delivery)
            finally:
                delivering.release()

    def failed(self, callback: str, change: KnowledgeChanged, error: Exception) -> None:
        """Report a callback that raised and was detached."""
        self.failures.append(SubscriberFailure(callback, change, error))
        detail = f"{type(error).__name__}: {error}"
        self._sink.emit(
            SubscriberDetached(
                t=change.t, agent=change.agent, callback=callback, revision=change.revision, detail=detail
            )
        )


def _name(callback: Callback) -> str:
    return getattr(callback, "__qualname__", type(callback).__qualname__)
