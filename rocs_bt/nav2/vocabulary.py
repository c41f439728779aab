"""Nav2's nodes as a vocabulary of missions, and the distributions of ROS 2 that have different ones."""

from __future__ import annotations

from collections.abc import Collection
from typing import TYPE_CHECKING, Final

from ..interfaces.vocabulary import Vocabulary

if TYPE_CHECKING:
    from ..trees.board import Board
    from ..trees.nodes import Registry

DISTRIBUTIONS: Final = ("humble", "jazzy", "kilted", "lyrical")
"""Distributions of ROS 2 that a mission may name, the oldest first; the last is meant if it names none."""

STATUSES: Final = "waypoint_statuses"
"""Blackboard key with the states of the goals."""


def _nodes(distribution: str) -> Registry:
    from .nodes import nav2_nodes

    return nav2_nodes(distribution)


def _begin(board: Board, used: Collection[str]) -> None:
    """Write the states of the goals, as Nav2's navigator does before the first tick."""
    from .goals import pending

    if STATUSES in used and "goals" in board:
        board.set_local(STATUSES, pending(board["goals"]))


VOCABULARY: Final = Vocabulary(
    nodes=_nodes,
    distributions=DISTRIBUTIONS,
    named="nav2_distribution",
    title="Nav2",
    about="its nodes do not need ROS",
    hint='Write nodes = "nav2:jazzy" in the scenario for another distribution, "nav2_servers" for a running Nav2.',
    common=frozenset({"FollowPath"}),  # an action of rocs_bt too
    inputs=("goal", "goals"),  # written by Nav2's navigator before the first tick
    begin=_begin,
    routes=("grid_astar", "visibility", "dijkstra"),
)
"""Nav2's nodes without ROS."""
