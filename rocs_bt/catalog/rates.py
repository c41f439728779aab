"""`[rate]` of a scenario: how often things happen."""

from __future__ import annotations

from dataclasses import dataclass, replace

from ..clock import Rate
from ..document import Table
from ..errors import InputError, RateError
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
        line=table.place()[0],
    )
    if len(table.faults) > before:
        return default  # numbers that are out of bounds divide nothing
    for key in ("control", "plan"):
        try:
            getattr(rate, f"{key}_rate")
        except InputError as error:
            table.adopt(key, error)
    return rate
