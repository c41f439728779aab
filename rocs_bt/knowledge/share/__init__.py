"""Sharing: agents keep the same knowledge, in one process, in several, or on several hosts (paper, 4.2)."""

from .inbox import Counts
from .messenger import ALL, Delivery, Letter, Letterbox, Mailbox, Messenger, packed, unpacked
from .network import Link, LocalNetwork, Network, SimulatedNetwork, Trouble
from .replica import Entry, Replica
from .scope import Scope
from .sharing import Ageing, Sharing

__all__ = [
    "ALL",
    "Ageing",
    "Counts",
    "Delivery",
    "Entry",
    "Letter",
    "Letterbox",
    "Link",
    "LocalNetwork",
    "Mailbox",
    "Messenger",
    "Network",
    "Replica",
    "Scope",
    "Sharing",
    "SimulatedNetwork",
    "Trouble",
    "packed",
    "unpacked",
]
