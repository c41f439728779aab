"""Nav2's nodes by their names, for each distribution."""

from __future__ import annotations

from typing import Final

from ..trees.nodes import BUILTIN, Registry, nodes_of
from . import conditions, costs, decorators, goals, motion, paths, planning, route
from .distributions import CHANGED
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
