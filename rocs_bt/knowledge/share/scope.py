"""What is shared and what stays private, under which names; and the check that every write of a peer must pass."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Collection
from typing import Any

from ...errors import InputError, KnowledgeError, unknown
from ...geometry import Pose2
from ..attribute import Attribute, Live
from ..declaration import NAME_LIMIT, is_name
from ..schema import Schema
from .replica import STAMP_LIMIT, Entry, Key, Plain

PEER = "peer"
"""As what a robot tells others of itself."""

EVERYTHING = "all"
"""The word for all kinds, a robot's own parts and blocks too."""

ORIGIN_LIMIT = 256
"""Characters in the name of a start."""

_OWN = ("part", "monitor", "analyze", "rule_set", "message")


class Scope:
    """Which kinds and relations are shared.

    By default the world is: everything but a robot's own parts, blocks and rules, which bear the same names in many
    robots. When those are shared too, others know them as `R2/ranges`. A robot itself is a `peer` to others.

    Args:
        schema: What may stand in the graph.
        kinds: The kinds to share, with all that extend them; `all` for the whole graph, none for the default.
        relations: The relations to share; all between shared kinds by default.
        private: Kinds, relations and nodes that nobody is told of, whatever else is said.

    Attributes:
        kinds: The kinds that are shared.
        relations: The relations that are shared.
        digest: The same for all peers that share the same under the same schema.

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
        said = [*sorted(self.kinds), "", *sorted(self.relations), "", *sorted(self._private), repr(schema.declared)]
        self.digest = hashlib.blake2b("\n".join(said).encode(), digest_size=8).hexdigest()

    def kind(self, kind: str) -> str | None:
        """As what others know a node of this kind; None where they do not."""
        told = PEER if kind in self._robots else kind
        return told if told in self.kinds else None

    def outside(self, agent: str, node: str, kind: str) -> str:
        """How others call a node of an agent's graph."""
        return f"{agent}/{node}" if kind in self._own and "/" not in node else node

    def attribute(self, kind: str, name: str) -> Attribute | None:
        """An attribute that is shared; None for one that is not."""
        declared = self._schema.kinds[kind].attributes
        live = any(a.type is Live for a in declared.values())
        # The name of a signal means the reader's own signal of that name, which is not the one that was meant.
        if name not in declared or declared[name].type is Live or (live and name == "signal"):
            return None
        return declared[name]

    def shares(self, *nodes: str) -> bool:
        """Whether none of these nodes is private."""
        return self._private.isdisjoint(nodes)

    def joins(self, relation: str, source: str | None, target: str | None) -> bool:
        """Whether others can know an edge between nodes of these kinds, as they are known outside."""
        declared, families = self._schema.relations[relation], self._schema.families
        return any(source in families[k] for k in declared.sources) and any(
            target in families[k] for k in declared.targets
        )

    def limits(self, relation: str) -> tuple[int | None, int | None]:
        """How many targets a source may have, and how many sources a target."""
        declared = self._schema.relations[relation]
        return 1 if declared.single else declared.max_targets, declared.max_sources

    def refuses(self, entry: Entry) -> str:
        """Why an entry of a peer cannot be taken; empty where it can. Equal on all peers of one digest."""
        if not 0 < entry.stamp < STAMP_LIMIT or not 0 < entry.number < 2**53:
            return f"no write can have the stamp {entry.stamp} and the number {entry.number}"
        if not is_origin(entry.origin):
            return f"{entry.origin[:NAME_LIMIT]!r} is no start of an agent"
        key = entry.key
        if len(key) not in (1, 3, 4):
            return "no key is like this"
        if (wrong := next((name for name in key[:3] if not is_name(name)), None)) is not None:
            return f"{wrong!r:.80} is no name: a name has 1 to {NAME_LIMIT} printable characters"
        if (len(key) == 4) != (key[-1:] == ("",)):
            return "no key is like this"
        owner = key[0].partition("/")[0]
        if owner != key[0] and owner != agent_of(entry.origin):
            return f"'{key[0]}' is for '{owner}' alone to tell"
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
                declared.check(thawed(declared, value))
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
            declared[name].check(thawed(declared[name], each))
        return ""


def is_origin(name: str) -> bool:
    """Whether a name is one of a start of an agent."""
    agent, _, start = name.partition("#")
    return is_name(agent) and bool(start) and len(name) <= ORIGIN_LIMIT and start.isprintable()


def agent_of(origin: str) -> str:
    """The agent that an origin is a start of."""
    return origin.partition("#")[0]


def frozen(value: Any) -> Plain:
    """A value of the graph as it is shared."""
    plain: Plain = list(value) if isinstance(value, tuple) else value
    return plain


def thawed(declared: Attribute, value: Plain) -> Any:
    """A shared value as the graph holds it.

    Raises:
        KnowledgeError: It cannot be one of this attribute.
    """
    if declared.type is Pose2:
        if not isinstance(value, list) or len(value) != 3 or not all(map(_finite, value)):
            raise KnowledgeError(f"must be {declared}, found {value!r}.")
        return Pose2(*value)
    return tuple(value) if declared.type is tuple and isinstance(value, list) else value


def _finite(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)
