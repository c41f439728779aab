"""K: the shared graph of world, robot and strategies, and the signal table (paper, 4.2 and 5.1)."""

from .attribute import Attribute, Live
from .declaration import Kind, Relation, Schema
from .graph import KnowledgeGraph, Stamp
from .knowledge import Knowledge
from .model import Model
from .robot import RobotModel
from .schema import POSE, SCHEMA
from .signals import SignalTable, SignalWriter
from .strategy import StrategyModel
from .subscription import SubscriberFailure, Subscription
from .world import WorldModel

__all__ = [
    "POSE",
    "SCHEMA",
    "Attribute",
    "Kind",
    "Knowledge",
    "KnowledgeGraph",
    "Live",
    "Model",
    "Relation",
    "RobotModel",
    "Schema",
    "SignalTable",
    "SignalWriter",
    "Stamp",
    "StrategyModel",
    "SubscriberFailure",
    "Subscription",
    "WorldModel",
]
