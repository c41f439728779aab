"""Cheapest path over known roads, by Dijkstra's algorithm.

Dijkstra, A note on two problems in connexion with graphs, Numerische Mathematik 1, 1959. For roadmaps in which costs
are not related to length; otherwise `astar` finds the same path faster.
"""

import networkx as nx

from rocs_bt.plan import RoadRoutePlanner


class Dijkstra(RoadRoutePlanner):
    """Plans over places and the relation `connects`; closed roads and doors are excluded."""

    def search(self, graph, start, goal, lower_bound):
        return nx.dijkstra_path(graph, start, goal)
