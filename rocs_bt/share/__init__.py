"""Sharing of knowledge between agents of one process, of several processes, or of several hosts (paper, 4.2)."""

from .inbox import Counts
from .messenger import ALL, Delivery, Mailbox, MessageQueue, Messenger, ReceivedMessage, packed, unpacked
from .network import Impairments, Link, LocalNetwork, Network, SimulatedNetwork
from .replica import Entry, Replica
from .scope import Scope
from .sharing import Ageing, Sharing

__all__ = [
    "ALL",
    "Ageing",
    "Counts",
    "Delivery",
    "Entry",
    "Impairments",
    "Link",
    "LocalNetwork",
    "Mailbox",
    "MessageQueue",
    "Messenger",
    "Network",
    "ReceivedMessage",
    "Replica",
    "Scope",
    "Sharing",
    "SimulatedNetwork",
    "packed",
    "unpacked",
]
