"""Mirror: synchronises an agent's graph with the replica of shared knowledge, in both directions."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

from ..base.errors import KnowledgeError
from ..base.geometry import Pose2, Twist2, along_arc
from ..event import KnowledgeChanged
from ..knowledge.attribute import plain
from ..knowledge.knowledge import Knowledge
from .inbox import Counts
from .replica import Entry, Key, Plain, Replica
from .scope import PEER, SharingScope, agent_of, from_shared
from .wire import fits

STATE = ("pose", "speed", "turn_rate", "spread", "z")
"""Attributes of a robot's node with which it reports its own state in every turn of sharing."""

EXTRAPOLATION_LIMIT = 5.0
"""Maximum time over which a peer's motion is extrapolated [s]."""

RATE_LIMIT = 1e6
"""Speed and turn rate above which a peer's motion is not extrapolated [m/s, rad/s]."""

_Dirty = tuple[str, ...]  # changed (node,), (node, attribute) or (source, relation, target), named as in the graph


class Mirror:
    """Synchronises one agent's graph with its replica: changes of the graph go out, writes of peers come in.

    Observations of the `self_reporting` agents are not shared, because these agents report their own state.
    """

    def __init__(
        self,
        knowledge: Knowledge,
        replica: Replica,
        scope: SharingScope,
        counts: Counts,
        wake: Callable[[], None] = lambda: None,
    ) -> None:
        self.self_reporting: dict[str, None] = {}
        self._knowledge = knowledge
        self._graph = knowledge.graph
        self._agent = knowledge.agent
        self._replica = replica
        self._scope = scope
        self._counts = counts
        self._wake = wake
        self._state: dict[str, Plain] = {}
        self._state_at = -math.inf  # [s] time at which `_state` was measured
        self._silent: set[str] = set()
        self._forgotten: set[str] = set()
        self._dirty: dict[_Dirty, None] = {}
        self._subscription = self._graph.subscribe(self._changed)
        for node in self._graph.nodes():
            self._dirty[(node,)] = None
            for name in self._graph.attributes(node):
                self._dirty[node, name] = None
        for source, target, relation in list(self._graph.view.edges(keys=True)):
            self._dirty[source, relation, target] = None

    @property
    def pending(self) -> bool:
        """Whether there are changes to publish."""
        return bool(self._dirty)

    def close(self) -> None:
        """End the subscription to the graph."""
        self._subscription.close()

    # -- from the graph to the replica ------------------------------------------------------------------------------

    def publish_state(self, t: float, *, halted: bool = False) -> None:
        """Mark this robot's own pose and motion for publication; if `halted`, with speeds of zero."""
        robot, signals = self._knowledge.robot, self._knowledge.signals
        pose = robot.pose(t)
        spread = signals.value("pose_spread", t) if "pose_spread" in signals else math.nan
        known = all(map(math.isfinite, pose))
        self._state_at = signals.stamp("pose") if known else t
        self._state["pose"] = list(pose) if known else None
        speeds = {"speed": robot.speed(t), "turn_rate": robot.turn_rate(t)}
        for name, value in {**speeds, "spread": spread, "z": robot.height(t)}.items():
            moves = halted and name in speeds
            self._state[name] = (0.0 if moves else value) if known and (moves or math.isfinite(value)) else None
        self._dirty.update(dict.fromkeys((self._agent, name) for name in STATE))
        if self.visible((self._agent,)) != self._scope.kind("robot"):  # peers took this robot for another kind
            self._dirty[(self._agent,)] = None

    def collect(self, t: float, most: int, *, first: bool = False) -> list[Entry]:
        """Write at most `most` changes of the graph into the replica; returns the entries to send to peers."""
        written: list[Entry] = []
        added: dict[Key, Plain] = {}
        for dirty in list(self._dirty)[:most]:
            self._dirty.pop(dirty)  # before the graph is read, so that a later change is recorded again
            for key in self._keys(dirty):
                value = self._graph_value(key)
                if value == self.visible(key) or (key[0] in self.self_reporting and len(key) == 3):
                    continue
                if len(key) == 1 and value is not None:
                    added.update(dict.fromkeys(self._replica.about(key[0])))
                state = key[0] == self._agent and key[-1] in STATE
                entry = self._replica.write(key, value, self._state_at if state else t, first=first)
                if fits(entry):
                    written.append(entry)
                else:
                    self._counts.untold += 1
        if added:  # peers may have shared attributes and edges of these new nodes before
            self.apply(added, t)
        self._counts.written += len(written)
        return written

    def _changed(self, change: KnowledgeChanged) -> None:
        if change.what == "attribute":
            self._dirty[change.subject, change.name] = None
        elif change.what.startswith("node"):
            self._dirty[(change.subject,)] = None
        else:
            self._dirty[change.subject, change.name, str(change.value)] = None
        self._wake()

    def _keys(self, dirty: _Dirty) -> list[Key]:
        """Keys of the replica that a change of the graph concerns; none if the change is private."""
        names = [self._shared_name(node) for node in (dirty[0], *dirty[2:])]
        if not self._scope.shares(*dirty[0:1], *dirty[2:], *names):
            return []
        if len(dirty) == 3:
            return [(names[0], dirty[1], names[1], "")] if dirty[1] in self._scope.relations else []
        there = self._graph.has(dirty[0])
        if len(dirty) == 1:
            return [(names[0],), *(key for key in self._replica.about(names[0]) if len(key) == 3 and not there)]
        if not there:
            return []
        kind = self._scope.kind(self._graph.kind(dirty[0]))
        return [] if kind is None or self._scope.attribute(kind, dirty[1]) is None else [(names[0], kind, dirty[1])]

    def _graph_value(self, key: Key) -> Plain:
        """Value in the graph that corresponds to a key of the replica; None if there is none."""
        graph, node = self._graph, self._local_name(key[0])
        if not graph.has(node) or (kind := self._scope.kind(graph.kind(node))) is None:
            return None
        if len(key) == 1:
            return kind
        if len(key) == 4:
            other = self._local_name(key[2])
            if not graph.has(other) or not self._scope.joins(key[1], kind, self._scope.kind(graph.kind(other))):
                return None
            attributes = graph.edge(node, key[1], other)
            if attributes is None:
                return None
            return {name: plain(v) for name, v in attributes.items()}
        if kind != key[1]:
            return None
        if node == self._agent and key[2] in STATE:
            return self._state.get(key[2])
        return plain(graph.attributes(node).get(key[2]))

    # -- from the replica to the graph ------------------------------------------------------------------------------

    def apply(self, before: Mapping[Key, Plain], t: float) -> None:
        """Apply writes of peers to the graph.

        Args:
            before: Value that the replica had before the writes, for each written key. A graph value that differs from
                it is a newer write of this agent, which is kept and published next.
            t: Present time [s].
        """
        edges = {key: None for key in before if len(key) == 4}
        with self._graph.locked():
            for node in dict.fromkeys(key[0] for key in before if len(key) != 4):
                if self._node(node, before, t):
                    edges.update({key: None for key in self._replica.about(node) if len(key) == 4})
            for key in edges:
                self._edges(key)

    def age(self, silent: set[str], forgotten: set[str], t: float) -> None:
        """Update the graph when agents have fallen silent, are to be forgotten, or have returned.

        Pose and motion of silent agents, and all writes of forgotten agents, are removed from the graph. The replica
        keeps both, to restore them when an agent returns and to answer the requests of peers.

        Args:
            silent: Agents with outdated pose and motion.
            forgotten: Agents with only outdated writes.
            t: Present time [s].
        """
        affected = (silent ^ self._silent) | (forgotten ^ self._forgotten)
        if not affected:
            return
        keys = [k for k, e in self._replica.entries.items() if agent_of(e.origin) in affected or k[0] in affected]
        before = {key: self.visible(key) for key in keys}
        self._silent, self._forgotten = set(silent), set(forgotten)
        self.apply({key: value for key, value in before.items() if value != self.visible(key)}, t)

    def visible(self, key: Key) -> Plain:
        """Value of a key in the replica; None if its writer is silent or forgotten, or a newer edge replaces it."""
        entry = self._replica.entries.get(key)
        if entry is None or entry.value is None:
            return None
        agent = agent_of(entry.origin)
        if agent in self._forgotten or (agent in self._silent and key[0] == agent and key[-1] in STATE):
            return None
        if len(key) == 4 and self._superseded(key):
            return None
        return entry.value

    def _node(self, name: str, before: Mapping[Key, Plain], t: float) -> bool:
        """Apply the replica's value of a node and of its attributes to the graph; True if the node was added."""
        node, graph = self._local_name(name), self._graph
        wanted = self.visible((name,))
        if node == self._agent or node != name:  # peers do not define this agent or its parts
            return False
        if (node,) in self._dirty:  # this agent has just added or removed it, which is published next
            return False
        there = self._graph_value((name,)) if graph.has(node) else None
        if graph.has(node) and there is None:
            self._counts.clashed += 1  # a node of a private kind has this name
            return False
        if there is not None and there != wanted and there == before.get((name,), there):
            graph.remove(node)
            there = None
        if wanted is None:
            return False
        values = self._values(name, str(wanted), t)
        if there is None:
            return self._add(node, str(wanted), values)
        if there == wanted:
            reported = name in self.self_reporting
            mine = {
                k[2]
                for k in before
                if len(k) == 3 and k[:2] == (name, wanted) and (reported or self._graph_value(k) == before[k])
            }
            self._try(lambda: graph.set(node, **{n: values.get(n) for n in sorted(mine)}))
        return False

    def _values(self, name: str, kind: str, t: float) -> dict[str, Any]:
        """Attributes of a node in the replica, in the graph's form; a self-reporting peer's pose is extrapolated."""
        values: dict[str, Any] = {}
        for key in self._replica.about(name):
            if len(key) == 3 and key[1] == kind and (value := self.visible(key)) is not None:
                declared = self._scope.attribute(kind, key[2])
                values[key[2]] = value if declared is None else from_shared(declared, value)
        if name in self.self_reporting and isinstance(pose := values.get("pose"), Pose2):
            age = min(max(0.0, t - self._replica.since[name, PEER, "pose"]), EXTRAPOLATION_LIMIT)
            twist = Twist2(values.get("speed") or 0.0, values.get("turn_rate") or 0.0)
            if all(abs(rate) < RATE_LIMIT for rate in twist):
                values["pose"] = along_arc(pose, twist, age)
        return values

    def _add(self, node: str, kind: str, values: dict[str, Any]) -> bool:
        declared = self._graph.schema.kinds[kind].attributes
        if any(a.required and name not in values for name, a in declared.items()):
            return False  # the node is added when its required attributes have arrived
        return self._try(lambda: self._graph.add(node, kind, **values))

    def _edges(self, key: Key) -> None:
        """Apply an edge of the replica to the graph, with all edges that compete for the relation's limits."""
        graph = self._graph
        among = [key] if self._scope.limits(key[1]) == (None, None) else self._rivals(key)
        wanted = [(each, self.visible(each)) for each in among]
        for each, value in sorted(wanted, key=lambda pair: pair[1] is not None):  # removals first
            source, target = self._local_name(each[0]), self._local_name(each[2])
            if not (graph.has(source) and graph.has(target)) or (source, each[1], target) in self._dirty:
                continue
            there = graph.edge(source, each[1], target)
            if value is None and there is not None:
                graph.unrelate(source, each[1], target)
            elif isinstance(value, dict) and value != self._graph_value(each):
                self._relate(source, each[1], target, {**dict.fromkeys(there or ()), **value})

    def _relate(self, source: str, relation: str, target: str, values: Mapping[str, Plain]) -> None:
        declared = self._graph.schema.relations[relation].attributes
        found = {name: from_shared(declared[name], value) for name, value in values.items()}
        self._try(lambda: self._graph.relate(source, relation, target, **found))

    def _rivals(self, key: Key) -> list[Key]:
        """Keys of the replica's edges that have the same relation and the same source or target as an edge."""
        about = (*self._replica.about(key[0]), *self._replica.about(key[2]))
        return list(
            dict.fromkeys(k for k in about if len(k) == 4 and k[1] == key[1] and (k[0] == key[0] or k[2] == key[2]))
        )

    def _superseded(self, key: Key) -> bool:
        """Whether an edge gives way to newer edges because the relation limits their number."""
        limits = self._scope.limits(key[1])
        if limits == (None, None):
            return False
        entry, entries = self._replica.entries[key], self._replica.entries
        rivals = [k for k in self._rivals(key) if entries[k].value is not None and entries[k].after(entry)]
        by_end = [sum(k[0] == key[0] for k in rivals), sum(k[2] == key[2] for k in rivals)]
        return any(most is not None and newer >= most for most, newer in zip(limits, by_end, strict=True))

    def _try(self, write: Callable[[], None]) -> bool:
        try:
            write()
        except KnowledgeError:  # the value was checked, so it conflicts with the present content
            self._counts.clashed += 1
            return False
        return True

    def _shared_name(self, node: str) -> str:
        graph = self._graph
        if graph.has(node):
            return self._scope.shared_name(self._agent, node, graph.kind(node))
        qualified = f"{self._agent}/{node}"
        return qualified if (qualified,) in self._replica.entries else node

    def _local_name(self, name: str) -> str:
        owner, _, own = name.partition("/")
        return own if own and owner == self._agent else name
