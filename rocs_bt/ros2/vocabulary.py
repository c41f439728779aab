"""Nodes that use ROS 2 as vocabularies of missions: Nav2 as it runs elsewhere; topics, services and actions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Final

from ..interfaces.vocabulary import Vocabulary
from ..nav2.vocabulary import VOCABULARY as NAV2

if TYPE_CHECKING:
    from ..trees.nodes import Node, Registry


def _servers(distribution: str) -> Registry:
    from ..nav2.nodes import nav2_nodes
    from ..trees.nodes import Registry
    from .nodes import NAV2_SERVERS

    called = {node.tag for node in NAV2_SERVERS}
    return Registry([*(n for tag, n in nav2_nodes(distribution).items() if tag not in called), *NAV2_SERVERS])


def _anywhere() -> Sequence[type[Node]]:
    from .nodes import ROS_NODES

    return ROS_NODES


SERVERS: Final = replace(NAV2, nodes=_servers, title="")
"""Nav2's nodes, those with a server, service or topic of a running Nav2 as its clients; never recognised."""

ANYWHERE: Final = Vocabulary(anywhere=_anywhere)
"""Nodes for any topic, service or action, in missions of every dialect."""
