"""A handful of agents that share, without bodies: what the tests of sharing play with."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.geometry import Pose2
from rocs_bt.base.signal import Signal
from rocs_bt.base.units import NONE
from rocs_bt.event import ListSink
from rocs_bt.knowledge import SCHEMA, Knowledge, Schema
from rocs_bt.share.network import Impairments, SimulatedNetwork
from rocs_bt.share.replica import Entry
from rocs_bt.share.scope import SharingScope
from rocs_bt.share.sharing import Ageing, Sharing
from rocs_bt.share.wire import Delta

TURN = 0.05  # [s]
NOW = 10**12  # a stamp of today's, on the simulated calendar


def entry(key: tuple[str, ...], value: Any, stamp: int = NOW, origin: str = "M#1", number: int = 1) -> Entry:
    """A write of a peer M, which may be a liar."""
    return Entry(key, value, stamp, origin, number)


def delta(*entries: Entry, sync=1, part=0, whole=1, scope="x", upto=None, ages=None) -> Delta:
    """Writes as they come over the line."""
    ages = [0.0] * len(entries) if ages is None else ages
    return Delta(sync, part, whole, scope, {}, upto or {}, list(entries), ages)


class Peers:
    """Agents R0, R1, ... on a simulated network, with a turn of sharing every 50 ms."""

    def __init__(self, count: int, seed: int = 0, schema: Schema = SCHEMA, key: bytes = b"", **scope: Any) -> None:
        self.clock = SimulatedClock(TURN)
        self.network = SimulatedNetwork(self.clock.now, np.random.default_rng(seed))
        self.sink = ListSink()
        self.names = [f"R{i}" for i in range(count)]
        self.error = dict.fromkeys(self.names, 0.0)  # of each one's calendar [s]
        self.starts = dict.fromkeys(self.names, 0)
        self.knowledge: dict[str, Knowledge] = {}
        self.sharing: dict[str, Sharing] = {}
        self.ageing = Ageing()
        self.schema, self.key, self.scope = schema, key, dict.fromkeys(self.names, scope)
        self.written: list[Entry] = []  # by whomever, ever

    def start(self, *names: str) -> Peers:
        """Start agents with empty heads; all by default."""
        for name in names or self.names:
            self.starts[name] += 1
            knowledge = self.knowledge[name] = Knowledge(name, self.clock, self.sink, self.schema)
            for signal, size in (("pose", 3), ("speed", 1), ("turn_rate", 1), ("height", 1)):
                knowledge.signals.declare(Signal(signal, size, (NONE,), max_age=math.inf))
            knowledge.signals.freeze()
            self.sharing[name] = sharing = Sharing(
                knowledge,
                SharingScope(self.schema, **self.scope[name]),
                self.network,
                origin=f"{name}#{self.starts[name]}",
                calendar=lambda name=name: self.clock.now() + 1e4 + self.error[name],
                key=self.key,
                ageing=self.ageing,
            )
            self._note_writes(sharing)
        return self

    def kill(self, name: str) -> None:
        """An agent is gone without a word."""
        self.network.leave(self.sharing.pop(name).replica.origin)
        del self.knowledge[name]

    def turn(self, count: int = 1) -> None:
        """Let so many turns pass."""
        for _ in range(count):
            for sharing in list(self.sharing.values()):
                sharing.run(self.clock.now())
            self.clock.advance()

    def settle(self, most: int = 1200) -> int:
        """Let turns pass until all agree and nothing is under way; how many that took."""
        for turns in range(most):
            if turns % 10 == 9 and self.agree():
                return turns
            self.turn()
        return most

    def agree(self) -> bool:
        """Whether everybody knows of everybody and holds the same."""
        alive = {sharing.replica.origin for sharing in self.sharing.values()}
        return (
            len({repr(sharing.replica.live) for sharing in self.sharing.values()}) == 1
            and len({repr(sorted(s.replica.seen.items())) for s in self.sharing.values()}) == 1
            and all(alive - {s.replica.origin} <= set(s.presence.starts.values()) for s in self.sharing.values())
            and not any(s.pending for s in self.sharing.values())
        )

    def _note_writes(self, sharing: Sharing) -> None:
        write = sharing.replica.write

        def noted(*args: Any, **kwargs: Any) -> Entry:
            self.written.append(write(*args, **kwargs))
            return self.written[-1]

        sharing.replica.write = noted


def picture(knowledge: Knowledge, scope: SharingScope) -> Mapping[str, Any]:
    """What an agent's graph says of all that is shared, as plain data; the robot itself as the peer that it is."""
    graph, found = knowledge.graph, {}
    for node in graph.nodes():
        kind = scope.kind(graph.kind(node))
        if kind is not None:
            attributes = graph.attributes(node)
            found[node] = (kind, {n: attributes[n] for n in sorted(attributes) if scope.attribute(kind, n) is not None})
    for source, target, relation in graph.view.edges(keys=True):
        kinds = [scope.kind(graph.kind(end)) for end in (source, target)]
        if relation in scope.relations and scope.joins(relation, *kinds):
            found[f"{source} -{relation}-> {target}"] = graph.edge(source, relation, target)
    return dict(sorted(found.items()))


__all__ = ["NOW", "TURN", "Impairments", "Peers", "Pose2", "delta", "entry", "picture"]
