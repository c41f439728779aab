"""The tables `[rate]`, `[share]` and `[[fact]]` of a scenario."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from ..base.clock import Rate
from ..base.errors import InputError, RateError, did_you_mean
from ..base.toml_table import Table
from ..base.units import FREQUENCY, TIME


@dataclass(frozen=True)
class RateSpec:
    """`[rate]` table: rates of physics, control, plan and sensors (docs/architecture.md).

    Attributes:
        physics: Physics step [s].
        control: Control rate [Hz].
        plan: Tick rate of the tree [Hz].
        sensors: Rate of every sensor [Hz]; None for the rates in each robot.toml.
        line: Line of the table in the file.
    """

    physics: float = 0.005
    control: float = 20.0
    plan: float = 10.0
    sensors: float | None = None
    line: int = 0

    @property
    def control_rate(self) -> Rate:
        """Control rate as a multiple of the physics step.

        Raises:
            RateError: The control period is not a multiple of the physics step.
        """
        return Rate.dividing(self.control, self.physics, "the control rate")

    @property
    def plan_rate(self) -> Rate:
        """Plan rate as a multiple of the control period.

        Raises:
            RateError: The plan period is not a multiple of the control period.
        """
        return Rate.dividing(self.plan, 1.0 / self.control, "the plan rate")

    def sensor_rate(self, hz: float | None, name: str = "") -> Rate:
        """Sensor rate as a multiple of the control period.

        Args:
            hz: Rate in robot.toml [Hz]; None for one reading per control period.
            name: Sensor's name, for the message.

        Raises:
            RateError: The sensor's period is not a multiple of the control period.
        """
        wanted = self.sensors or hz or self.control
        try:
            return Rate.dividing(wanted, 1.0 / self.control, f"the rate of sensor '{name}'")
        except RateError as error:
            common = f'Or set one rate for all sensors: sensors = "{self.control:g} Hz" under [rate].'
            raise RateError(*(replace(f, hint=f"{f.hint} {common}".strip()) for f in error.faults)) from error


def read_rate(table: Table) -> RateSpec:
    """Read a `[rate]` table; faults are noted in it."""
    default, before = RateSpec(), len(table.faults)
    rate = RateSpec(
        physics=table.quantity("physics", TIME, default.physics, low=1e-5, high=0.1),
        control=table.quantity("control", FREQUENCY, default.control, low=0.1, high=1e4),
        plan=table.quantity("plan", FREQUENCY, default.plan, low=0.01, high=1e4),
        sensors=table.quantity("sensors", FREQUENCY, low=0.01, high=1e4) if "sensors" in table else None,
        line=table.position()[0],
    )
    if len(table.faults) > before:
        return default  # divisibility is not checked for rates that are out of bounds
    for key in ("control", "plan"):
        try:
            getattr(rate, f"{key}_rate")
        except InputError as error:
            table.adopt(key, error)
    return rate


@dataclass(frozen=True)
class ShareSpec:
    """`[share]` table: knowledge shared between agents. A scenario without it shares nothing.

    Attributes:
        agents: Names of the agents that share.
        kinds: Shared kinds of nodes; `all` for the whole graph; the kinds of the world by default.
        relations: Shared relations; all relations between shared kinds by default.
        private: Kinds, relations and nodes that are never sent.
        rate: Maximum send rate of an agent [Hz].
        lost_after: Time after which pose and motion of a vanished robot count as unknown [s].
        forget_after: Time after which all other facts from a vanished robot are dropped [s].
        latency: Latency of messages in lockstep [s].
        jitter: Maximum additional latency in lockstep [s].
        loss: Fraction of messages lost in lockstep [1].
        listen: Address of this process, `host:port`; empty to share within this process only.
        peers: Addresses of other processes.
        keys: Folder of this process' keys; None on loopback.
        group: Name of the group; groups on one network are separate.
        line: Line of the table in the file.
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
    """Read a scenario's `[share]` table; None if it has none. Faults are noted in the table."""
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
        table.fault(
            "group", f"'{group}' is not a valid group name.", "Use letters, digits and '_', beginning with a letter."
        )
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
    """One `[[fact]]` table: a new node of the agents' Knowledge, or additions to a node.

    Attributes:
        node: Node's name.
        kind: Node's kind; empty if the table extends a node that is declared elsewhere.
        agents: Names of the agents that receive the fact.
        at: Time at which the agents receive the fact [s]; 0 for initial knowledge.
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
        """Line of the table in the file."""
        return self.table.position()[0]


def read_facts(root: Table, agents: Sequence[str]) -> tuple[FactSpec, ...]:
    """Read the facts of a scenario; faults are noted in their tables."""
    return tuple(_fact(table, agents) for table in root.tables("fact"))


def _fact(table: Table, agents: Sequence[str]) -> FactSpec:
    receivers = tuple(table.texts("agents", list(agents)))
    for name in receivers:
        if name not in agents:
            table.fault("agents", f"no agent is named '{name}'.", did_you_mean(name, agents, "The scenario"))
    for key in table.keys():  # noqa: SIM118 - a Table is no mapping
        table.raw(key)  # accepted here; the schema checks them later
    rest = Table(table.file, table.data, table.key, table.positions)  # its faults are noted later
    at = table.quantity("at", TIME, 0.0, low=0.0, high=86400.0)
    return FactSpec(table.text("node"), table.text("kind", ""), receivers, at, rest)
