"""Cheapest path over known roads, by A*.

A* (Hart, Nilsson and Raphael, IEEE Transactions on Systems Science and Cybernetics 4, 1968); the heuristic is the
straight distance times the cost of the cheapest road.
"""

import networkx as nx

from rocs_bt.plan import RoadRoutePlanner


class Astar(RoadRoutePlanner):
    """Plans over places and the relation `connects`; closed roads and doors are excluded."""

    def search(self, graph, start, goal, lower_bound):
        return nx.astar_path(graph, start, goal, heuristic=lower_bound)
