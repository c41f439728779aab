"""The `[share]` table of a scenario: what its agents share of their knowledge, and through what."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from ..document import Table
from ..errors import did_you_mean
from ..units import FREQUENCY, TIME


@dataclass(frozen=True)
class ShareSpec:
    """Who shares what. Where a scenario has no such table nobody shares anything.

    Attributes:
        agents: Who shares.
        kinds: The kinds of nodes that are shared; `all` for the whole graph, the world's by default.
        relations: The relations; all between shared kinds by default.
        private: Kinds, relations and nodes that nobody is told of.
        rate: How often an agent sends at most [1/s].
        lost_after: For how long the state of a vanished robot is taken for true [s].
        forget_after: The same for all else that it told [s].
        latency: How long a message takes in lockstep [s].
        jitter: How much longer it may take [s].
        loss: The part of messages that is lost there [1].
        listen: Where this process hears others, as `host:port`; empty where agents of this process share alone.
        peers: Where other processes listen.
        keys: The folder of this process' keys; None on loopback.
        group: Which of several groups on one network.
        line: Where the table stands in the file.
    """

    agents: tuple[str, ...]
    kinds: tuple[str, ...] = ()
    relations: tuple[str, ...] = ()
    private: tuple[str, ...] = ()
    rate: float = 50.0
    lost_after: float = 3.0
    forget_after: float = math.inf
    latency: float = 0.0
    jitter: float = 0.0
    loss: float = 0.0
    listen: str = ""
    peers: tuple[str, ...] = ()
    keys: Path | None = None
    group: str = "robots"
    line: int = 0


def read_share(root: Table, agents: Sequence[str]) -> ShareSpec | None:
    """A scenario's `[share]`; None where it has none. Faults are noted in the table."""
    if "share" not in root:
        return None
    table = root.table("share")
    sharing = tuple(table.texts("agents", list(agents)))
    for name in sharing:
        if name not in agents:
            table.fault("agents", f"no agent is named '{name}'.", did_you_mean(name, agents, "The scenario"))
    default = ShareSpec(sharing)
    keys, loss = table.text("keys", ""), table.raw("loss", 0.0)
    if not isinstance(loss, (int, float)) or isinstance(loss, bool) or not 0.0 <= loss < 1.0:
        table.fault("loss", f"loss must be a number from 0 to below 1, found {loss!r}.")
        loss = 0.0
    group = table.text("group", default.group)
    if not group.isidentifier():
        table.fault("group", f"'{group}' cannot name a group.", "Use letters, digits and '_', beginning with a letter.")
    return ShareSpec(
        agents=sharing,
        kinds=tuple(table.texts("kinds", [])),
        relations=tuple(table.texts("relations", [])),
        private=tuple(table.texts("private", [])),
        rate=table.quantity("rate", FREQUENCY, default.rate, low=0.1, high=1000.0),
        lost_after=table.quantity("lost_after", TIME, default.lost_after, low=0.0, high=math.inf),
        forget_after=table.quantity("forget_after", TIME, default.forget_after, low=0.0, high=math.inf),
        latency=table.quantity("latency", TIME, 0.0, low=0.0, high=60.0),
        jitter=table.quantity("jitter", TIME, 0.0, low=0.0, high=60.0),
        loss=float(loss),
        listen=table.text("listen", ""),
        peers=tuple(table.texts("peers", [])),
        keys=table.beside(keys) if keys else None,
        group=group,
        line=table.place()[0],
    )
