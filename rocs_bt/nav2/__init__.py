"""Behaviour-tree nodes with Nav2's names, ports and outcomes, implemented with the robot's planners and actions."""

from __future__ import annotations

from typing import Final

from ..base.dialect import NEWEST
from ..trees.nodes import BUILTIN, Registry, nodes_of
from . import conditions, costs, decorators, goals, motion, paths, planning, route
from .distributions import CHANGED
from .goals import pending
from .servers import cancel_nodes
from .tables import table_nodes

_MODULES = (planning, route, motion, paths, goals, costs, conditions, decorators)
OWN: Final = (*(node for module in _MODULES for node in nodes_of(module)), *table_nodes(), *cancel_nodes())
"""Nav2's nodes that BehaviorTree.CPP does not have, except Nav2's control nodes, which are in `BUILTIN`."""

NAV2: Final = Registry([*(node for tag, node in BUILTIN.items() if tag not in {n.tag for n in OWN}), *OWN])
"""Nodes available in a mission with `nodes = "nav2"`, in addition to its robot's actions."""


def nav2_nodes(distribution: str = NEWEST) -> Registry:
    """Nodes as in Nav2 of a distribution of ROS 2.

    Args:
        distribution: One of `DISTRIBUTIONS`.
    """
    changed = {node.tag: node for node in CHANGED[distribution]}
    return Registry([changed.get(tag, node) for tag, node in NAV2.items()])


ELSEWHERE: Final = {
    tag: (f"'{tag}' is a node of Nav2.", 'Write nodes = "nav2" in the scenario; check and show take --nodes nav2.')
    for tag in NAV2
    if tag not in BUILTIN
}
"""Message and hint for each of Nav2's nodes, if a mission with `nodes = "rocs"` uses it."""

ONLY_NAV2: Final = ELSEWHERE.keys() - {"FollowPath"}
"""Nodes by which a mission of Nav2 is recognised; FollowPath is an action of rocs_bt too."""

GOAL_KEYS: Final = ("goal", "goals")
"""Blackboard keys that Nav2's navigator writes before the first tick; here they are parameters of the mission."""

STATUSES: Final = "waypoint_statuses"
"""Blackboard key with the states of the goals, which Nav2's navigator also writes before the first tick."""

ROUTES: Final = ("grid_astar", "visibility", "dijkstra")
"""Names of the route planners that the nodes use by default."""

__all__ = ["ELSEWHERE", "GOAL_KEYS", "NAV2", "ONLY_NAV2", "OWN", "ROUTES", "STATUSES", "nav2_nodes", "pending"]
