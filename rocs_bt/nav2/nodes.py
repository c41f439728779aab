"""Nav2's nodes by their names, for each distribution."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final

from ..trees.nodes import BUILTIN, Node, Registry, nodes_of
from ..trees.nodes.control.navigation import RoundRobin
from . import conditions, costs, decorators, goals, motion, paths, planning, route
from .costs import INSCRIBED, LETHAL, IsPathValid
from .motion import FollowPath
from .paths import TruncatePathLocal
from .servers import cancel_nodes
from .tables import table_nodes

_MODULES = (planning, route, motion, paths, goals, costs, conditions, decorators)
OWN: Final = (*(node for module in _MODULES for node in nodes_of(module)), *table_nodes(), *cancel_nodes())
"""Nav2's nodes that BehaviorTree.CPP does not have, except Nav2's control nodes, which are in `BUILTIN`."""

NAV2: Final = Registry([*(node for tag, node in BUILTIN.items() if tag not in {n.tag for n in OWN}), *OWN])
"""Nodes available in a mission with `nodes = "nav2"`, in addition to its robot's actions."""


def nav2_nodes(distribution: str) -> Registry:
    """Nodes as in Nav2 of a distribution of ROS 2, one of `DISTRIBUTIONS`."""
    changed = {node.tag: node for node in CHANGED.get(distribution, ())}
    return Registry([changed.get(tag, node) for tag, node in NAV2.items()])


def _variant(node: type[Node], **members: Any) -> type[Node]:
    return type(node.__name__, (node,), {"__doc__": node.__doc__, "__module__": __name__, **members})


def _bad(self: Any, cost: int, round_: bool) -> bool:
    return cost == LETHAL or (round_ and cost == INSCRIBED)


_ROUND: Final = _variant(RoundRobin, wrap_around=True)
_NEAREST_ONLY: Final = _variant(TruncatePathLocal, whole_rest=False)
_INVALID: Final = _variant(FollowPath, empty_code=103)
_UNKNOWN_IS_FREE: Final = _variant(IsPathValid, bad=_bad)

CHANGED: Final[Mapping[str, Sequence[type[Node]]]] = {
    "humble": (_ROUND, _NEAREST_ONLY, _variant(FollowPath, empty_code=0), _UNKNOWN_IS_FREE),
    "jazzy": (_ROUND, _NEAREST_ONLY, _INVALID, _UNKNOWN_IS_FREE),
    "kilted": (_ROUND, _NEAREST_ONLY, _INVALID),
}
"""Nodes that differ from the newest ones, by distribution."""
