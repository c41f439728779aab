"""The cheapest way over the roads that are known, searched in all directions alike.

Dijkstra, A note on two problems in connexion with graphs, Numerische Mathematik 1, 1959. For a roadmap in which length
says little of what a way costs; where it does, `astar` finds the same way sooner.
"""

import networkx as nx

from rocs_bt.plan import RoadRoutePlanner


class Dijkstra(RoadRoutePlanner):
    """Plans over places and the relation `connects`; roads and doors that are closed are left out."""

    def search(self, graph, start, goal, least):
        return nx.dijkstra_path(graph, start, goal)
