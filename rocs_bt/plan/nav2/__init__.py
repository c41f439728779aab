"""Nav2's nodes, with Nav2's names, ports and outcomes, on the planners and actions of the robot."""

from __future__ import annotations

from typing import Final

from ...trees.nodes import BUILTIN, Registry, nodes_of
from . import conditions, decorators, motion, planning

OWN: Final = tuple(node for module in (planning, motion, conditions, decorators) for node in nodes_of(module))
"""Nav2's nodes that BehaviorTree.CPP does not have, its control nodes apart."""

NAV2: Final = Registry([*(node for tag, node in BUILTIN.items() if tag not in {n.tag for n in OWN}), *OWN])
"""The nodes that a mission with `nodes = "nav2"` may name, beside its robot's actions."""

ELSEWHERE: Final = {
    tag: (f"'{tag}' is a node of Nav2.", 'Write nodes = "nav2" in the scenario; check and show take --nodes nav2.')
    for tag in NAV2
    if tag not in BUILTIN
}
"""What a check says of these nodes in a mission of another dialect: message and hint."""

GOAL_KEYS: Final = ("goal", "goals")
"""Keys that Nav2's navigator writes before the first tick; here they are parameters of the mission."""

ROUTES: Final = ("grid_astar", "visibility", "dijkstra")
"""Route planners that the nodes use without naming them."""
