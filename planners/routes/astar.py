"""The cheapest way over the roads that are known, searched towards the goal.

A* (Hart, Nilsson and Raphael, IEEE Transactions on Systems Science and Cybernetics 4, 1968): what is left is at least
the straight distance, at the price of the cheapest road.
"""

import networkx as nx

from rocs_bt.plan import RoadRoutePlanner


class Astar(RoadRoutePlanner):
    """Plans over places and the relation `connects`; roads and doors that are closed are left out."""

    def search(self, graph, start, goal, least):
        return nx.astar_path(graph, start, goal, heuristic=least)
