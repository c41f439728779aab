"""`[[fact]]` of a scenario: what its agents know at the start, beside the places of `[[place]]`, and are told later."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ..document import Table
from ..errors import did_you_mean
from ..units import TIME


@dataclass(frozen=True)
class FactSpec:
    """One `[[fact]]`: a node of the agents' Knowledge, or more about one.

    Attributes:
        node: The node's name.
        kind: Its kind; empty where the node is told of elsewhere and this says more about it.
        agents: Whose Knowledge it goes into.
        at: When they are told [s]; 0 for what they know at the start.
        told: The table; its other keys are attributes of the kind and relations, which the agents' schema types.
    """

    node: str
    kind: str
    agents: tuple[str, ...]
    at: float
    told: Table

    KEYS = ("node", "kind", "agents", "at")

    @property
    def line(self) -> int:
        """Where its table stands in the file."""
        return self.told.place()[0]


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
    alone = Table(table.file, table.data, table.key, table.places)  # whose faults are noted when the schema is known
    at = table.quantity("at", TIME, 0.0, low=0.0, high=86400.0)
    return FactSpec(table.text("node"), table.text("kind", ""), told, at, alone)
