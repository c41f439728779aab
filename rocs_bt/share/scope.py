"""Scope of sharing: which nodes are shared, their names at peers, and the check of every write of a peer."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Collection
from typing import Any

from ..base.errors import InputError, KnowledgeError, unknown
from ..base.geometry import Pose2
from ..knowledge.attribute import Attribute, Live
from ..knowledge.declaration import NAME_LIMIT, is_name
from ..knowledge.schema import Schema
from .replica import STAMP_LIMIT, Entry, Key, Plain

PEER = "peer"
"""Kind that a robot's node has in the graphs of other robots."""

EVERYTHING = "all"
"""Keyword for all kinds, including a robot's own parts and blocks."""

ORIGIN_LIMIT = 256
"""Maximum number of characters of an origin."""

_OWN = ("part", "monitor", "analyze", "rule_set", "message")


class SharingScope:
    """Kinds and relations that are shared.

    By default, all kinds are shared except a robot's own parts, blocks, rules and messages; their nodes have the same
    names in many robots. If they are shared too, their names at peers are such as `R2/ranges`. The node of a robot is
    of kind `peer` at its peers.

    Args:
        schema: Schema of the graph.
        kinds: Kinds to share, including kinds that extend them; `all` for the whole graph, empty for the default.
        relations: Relations to share; empty for all between shared kinds.
        private: Kinds, relations and nodes that are never shared.

    Attributes:
        kinds: Shared kinds.
        relations: Shared relations.
        digest: Hash of scope and schema; equal for peers that share the same kinds and relations.

    Raises:
        InputError: No such kind or relation; lists what exists.
    """

    def __init__(
        self,
        schema: Schema,
        kinds: Collection[str] = (),
        relations: Collection[str] = (),
        private: Collection[str] = (),
    ) -> None:
        faults = [unknown("kind", n, schema.kinds, "The schema") for n in kinds if n not in (EVERYTHING, *schema.kinds)]
        faults += [
            unknown("relation", n, schema.relations, "The schema") for n in relations if n not in schema.relations
        ]
        if faults:
            raise InputError(*faults)
        own = {kind for name in _OWN for kind in schema.families[name]}
        wanted = {kind for name in kinds if name != EVERYTHING for kind in schema.families[name]}
        if EVERYTHING in kinds:
            wanted = set(schema.kinds)
        hidden = {kind for name in private if name in schema.kinds for kind in schema.families[name]}
        robots = schema.families["robot"]
        self._schema = schema
        self._own = own
        self._robots = robots
        self.kinds = frozenset((wanted or set(schema.kinds) - own) - hidden - robots)
        self.relations = frozenset(relations or schema.relations) - frozenset(private)
        self._private = frozenset(private) - set(schema.kinds) - set(schema.relations)
        parts = [*sorted(self.kinds), "", *sorted(self.relations), "", *sorted(self._private), repr(schema.declared)]
        self.digest = hashlib.blake2b("\n".join(parts).encode(), digest_size=8).hexdigest()

    def kind(self, kind: str) -> str | None:
        """Kind that nodes of a kind have in the graphs of peers; None if such nodes are not shared."""
        shared = PEER if kind in self._robots else kind
        return shared if shared in self.kinds else None

    def shared_name(self, agent: str, node: str, kind: str) -> str:
        """Name of an agent's node in the graphs of peers."""
        return f"{agent}/{node}" if kind in self._own and "/" not in node else node

    def attribute(self, kind: str, name: str) -> Attribute | None:
        """Declaration of an attribute of a kind; None if the attribute is not shared."""
        declared = self._schema.kinds[kind].attributes
        live = any(a.type is Live for a in declared.values())
        # At a peer, the name of a signal would refer to the peer's own signal of that name.
        if name not in declared or declared[name].type is Live or (live and name == "signal"):
            return None
        return declared[name]

    def shares(self, *nodes: str) -> bool:
        """Whether none of these nodes is private."""
        return self._private.isdisjoint(nodes)

    def joins(self, relation: str, source: str | None, target: str | None) -> bool:
        """Whether a relation can join nodes of these kinds; the kinds are those at peers."""
        declared, families = self._schema.relations[relation], self._schema.families
        return any(source in families[k] for k in declared.sources) and any(
            target in families[k] for k in declared.targets
        )

    def limits(self, relation: str) -> tuple[int | None, int | None]:
        """Maximum numbers of outgoing and of incoming edges of a node under a relation; None for no limit."""
        declared = self._schema.relations[relation]
        return 1 if declared.single else declared.max_targets, declared.max_sources

    def refuses(self, entry: Entry) -> str:
        """Reason to refuse an entry of a peer; empty if acceptable. Agents with equal `digest` decide equally."""
        if not 0 < entry.stamp < STAMP_LIMIT or not 0 < entry.number < 2**53:
            return f"the stamp {entry.stamp} or the number {entry.number} is out of range"
        if not is_origin(entry.origin):
            return f"{entry.origin[:NAME_LIMIT]!r} is not a start of an agent"
        key = entry.key
        if len(key) not in (1, 3, 4):
            return "the key is malformed"
        if (wrong := next((name for name in key[:3] if not is_name(name)), None)) is not None:
            return f"{wrong!r:.80} is not a name: a name has 1 to {NAME_LIMIT} printable characters"
        if (len(key) == 4) != (key[-1:] == ("",)):
            return "the key is malformed"
        owner = key[0].partition("/")[0]
        if owner != key[0] and owner != agent_of(entry.origin):
            return f"only '{owner}' may write '{key[0]}'"
        try:
            return self._wrong(key, entry.value)
        except KnowledgeError as error:
            return str(error)

    def _wrong(self, key: Key, value: Plain) -> str:
        if not self.shares(*key[:1], *key[2:3] if len(key) == 4 else ()):
            return "it is private"
        if len(key) == 1:
            return "" if value is None or value in self.kinds else f"nodes of kind {value!r} are not shared"
        if len(key) == 3:
            if key[1] not in self.kinds:
                return f"nodes of kind '{key[1]}' are not shared"
            declared = self.attribute(key[1], key[2])
            if declared is None:
                return f"a {key[1]} has no attribute '{key[2]}' to share"
            if value is not None:
                declared.check(from_shared(declared, value))
            return ""
        if key[1] not in self.relations:
            return f"'{key[1]}' is not shared"
        return self._wrong_edge(key[1], value)

    def _wrong_edge(self, relation: str, value: Plain) -> str:
        declared = self._schema.relations[relation].attributes
        if value is None:
            return ""
        if not isinstance(value, dict):
            return f"an edge has attributes, found {value!r}"
        for name, each in value.items():
            if name not in declared:
                return f"'{relation}' has no attribute {name!r:.80}"
            declared[name].check(from_shared(declared[name], each))
        return ""


def is_origin(name: str) -> bool:
    """Whether a name has the form `<agent>#<start>`, which identifies one start of an agent."""
    agent, _, start = name.partition("#")
    return is_name(agent) and bool(start) and len(name) <= ORIGIN_LIMIT and start.isprintable()


def agent_of(origin: str) -> str:
    """Name of the agent in an origin `agent#start`."""
    return origin.partition("#")[0]


def from_shared(declared: Attribute, value: Plain) -> Any:
    """Convert a shared value to the form of the graph.

    Raises:
        KnowledgeError: The value does not fit the attribute.
    """
    if declared.type is Pose2:
        if not isinstance(value, list) or len(value) != 3 or not all(map(_finite, value)):
            raise KnowledgeError(f"must be {declared}, found {value!r}.")
        return Pose2(*value)
    return tuple(value) if declared.type is tuple and isinstance(value, list) else value


def _finite(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)
