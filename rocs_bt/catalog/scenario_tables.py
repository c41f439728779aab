"""The tables `[rate]` and `[[fact]]` of a scenario."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Annotated

from ..base.clock import Rate
from ..base.errors import InputError, RateError
from ..base.units import FREQUENCY, TIME, Bounds
from ..declare import Names, Open, Rest, Value, Wrong
from .marks import At

_FAST = Annotated[float, FREQUENCY, Bounds(0.01, 1e4)]

AGENTS = Names("agent", "no agent", all=True)
"""Mark of a list of agents; all of them if it is not given."""


class RateSpec(Value):
    """`[rate]` table: rates of physics, control, plan and sensors (docs/architecture.md).

    Attributes:
        physics: Physics step [s].
        control: Control rate [Hz].
        plan: Tick rate of the tree [Hz].
        sensors: Rate of every sensor [Hz]; None for the rates in each robot.toml.
    """

    physics: Annotated[float, TIME, Bounds(1e-5, 0.1)] = 0.005
    control: Annotated[float, FREQUENCY, Bounds(0.1, 1e4)] = 20.0
    plan: _FAST = 10.0
    sensors: _FAST | None = None

    def _check(self) -> Iterator[Wrong]:
        """Faults of rates that do not divide."""
        for key in ("control", "plan"):
            try:
                getattr(self, f"{key}_rate")
            except InputError as error:
                yield from (Wrong(key, fault.message, fault.hint) for fault in error.faults)

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


class FactSpec(Value):
    """One `[[fact]]` table: a new node of the agents' Knowledge, or additions to a node.

    Attributes:
        node: Node's name.
        kind: Node's kind; empty if the table extends a node that is declared elsewhere.
        agents: Names of the agents that receive the fact.
        at: Time at which the agents receive the fact [s]; 0 for initial knowledge.
        attributes: Remaining keys: attributes and relations of the node, typed by the agents' schema.
    """

    node: str
    kind: str = ""
    agents: Annotated[tuple[str, ...], AGENTS] = ()
    at: At = 0.0
    attributes: Annotated[Open, Rest()] = Open()
