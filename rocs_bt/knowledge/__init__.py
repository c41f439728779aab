"""K of MAPE-K: the shared graph of world, robot and strategies, and the signal table (paper, 4.2 and 5.1).

The only folder that imports networkx. All blocks and the layers above import it.
"""

from ..control.prediction import HYPOTHESES
from .attribute import Attribute, Live
from .base import Model
from .declaration import NodeKind, Relation
from .graph import KnowledgeGraph
from .knowledge import Knowledge
from .movers import Movers
from .occupancy import FREE, OCCUPIED, UNKNOWN, OccupancyGrid, View, Window
from .query import Answers, Find, Query, QueryContext, compile_query, find
from .readable import Readable, Stamp
from .roadmap import Roadmap, Route, add_lattice_roads, segment_distance
from .robot import RobotModel
from .schema import POSE, SCHEMA, Schema, load_schema, schema_text
from .signals import SignalTable, SignalWriter
from .strategy import Candidate, Choice, StrategyModel
from .subscription import SubscriberFailure, Subscription
from .world import WorldModel

__all__ = [
    "FREE",
    "HYPOTHESES",
    "OCCUPIED",
    "POSE",
    "SCHEMA",
    "UNKNOWN",
    "Answers",
    "Attribute",
    "Candidate",
    "Choice",
    "Find",
    "Knowledge",
    "KnowledgeGraph",
    "Live",
    "Model",
    "Movers",
    "NodeKind",
    "OccupancyGrid",
    "Query",
    "QueryContext",
    "Readable",
    "Relation",
    "Roadmap",
    "RobotModel",
    "Route",
    "Schema",
    "SignalTable",
    "SignalWriter",
    "Stamp",
    "StrategyModel",
    "SubscriberFailure",
    "Subscription",
    "View",
    "Window",
    "WorldModel",
    "add_lattice_roads",
    "compile_query",
    "find",
    "load_schema",
    "schema_text",
    "segment_distance",
]
