"""Tables of a scenario beside robots and places: `[rate]`, `[share]` and `[[fact]]`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from ..clock import Rate
from ..document import Table
from ..errors import InputError, RateError, did_you_mean
from ..units import FREQUENCY, TIME


@dataclass(frozen=True)
class RateSpec:
    """The `[rate]` table: how often things happen (docs/architecture.md).

    Attributes:
        physics: Length of a physics step [s].
        control: Control periods per second [1/s].
        plan: Ticks of the tree per second [1/s].
        sensors: Readings per second of every sensor [1/s]; None for what each robot.toml says.
        line: Where the table stands in the file.
    """

    physics: float = 0.005
    control: float = 20.0
    plan: float = 10.0
    sensors: float | None = None
    line: int = 0

    @property
    def control_rate(self) -> Rate:
        """The control rate, over physics steps.

        Raises:
            RateError: It does not divide.
        """
        return Rate.dividing(self.control, self.physics, "the control rate")

    @property
    def plan_rate(self) -> Rate:
        """The plan rate, over control periods.

        Raises:
            RateError: It does not divide.
        """
        return Rate.dividing(self.plan, 1.0 / self.control, "the plan rate")

    def sensor_rate(self, hz: float | None, name: str = "") -> Rate:
        """A sensor's rate, over control periods.

        Args:
            hz: What robot.toml says [1/s]; None for one reading in each control period.
            name: The sensor, for the message.

        Raises:
            RateError: It does not divide.
        """
        wanted = self.sensors or hz or self.control
        try:
            return Rate.dividing(wanted, 1.0 / self.control, f"the rate of sensor '{name}'")
        except RateError as error:
            all_alike = f'Or have all sensors keep step: sensors = "{self.control:g} Hz" under [rate].'
            raise RateError(*(replace(f, hint=f"{f.hint} {all_alike}".strip()) for f in error.faults)) from error


def read_rate(table: Table) -> RateSpec:
    """The rates that a table holds; faults are noted in it."""
    default, before = RateSpec(), len(table.faults)
    rate = RateSpec(
        physics=table.quantity("physics", TIME, default.physics, low=1e-5, high=0.1),
        control=table.quantity("control", FREQUENCY, default.control, low=0.1, high=1e4),
        plan=table.quantity("plan", FREQUENCY, default.plan, low=0.01, high=1e4),
        sensors=table.quantity("sensors", FREQUENCY, low=0.01, high=1e4) if "sensors" in table else None,
        line=table.position()[0],
    )
    if len(table.faults) > before:
        return default  # numbers that are out of bounds divide nothing
    for key in ("control", "plan"):
        try:
            getattr(rate, f"{key}_rate")
        except InputError as error:
            table.adopt(key, error)
    return rate


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
        line=table.position()[0],
    )


@dataclass(frozen=True)
class FactSpec:
    """One `[[fact]]`: a node of the agents' Knowledge, or more about one.

    Attributes:
        node: The node's name.
        kind: Its kind; empty where the node is told of elsewhere and this says more about it.
        agents: Whose Knowledge it goes into.
        at: When they are told [s]; 0 for what they know at the start.
        table: Remaining keys: attributes and relations of the node, typed by the agents' schema.
    """

    node: str
    kind: str
    agents: tuple[str, ...]
    at: float
    table: Table

    KEYS = ("node", "kind", "agents", "at")

    @property
    def line(self) -> int:
        """Where its table stands in the file."""
        return self.table.position()[0]


def read_facts(root: Table, agents: Sequence[str]) -> tuple[FactSpec, ...]:
    """The facts of a scenario; faults are noted in their tables."""
    return tuple(_fact(table, agents) for table in root.tables("fact"))


def _fact(table: Table, agents: Sequence[str]) -> FactSpec:
    told = tuple(table.texts("agents", list(agents)))
    for name in told:
        if name not in agents:
            table.fault("agents", f"no agent is named '{name}'.", did_you_mean(name, agents, "The scenario"))
    for key in table.keys():  # noqa: SIM118 - a Table is no mapping; what these are only the schema tells
        table.raw(key)
    alone = Table(table.file, table.data, table.key, table.positions)  # whose faults are noted when the schema is known
    at = table.quantity("at", TIME, 0.0, low=0.0, high=86400.0)
    return FactSpec(table.text("node"), table.text("kind", ""), told, at, alone)
