"""The tables `[rate]`, `[[fact]]`, `[[ground]]` and `[[push]]` of a scenario."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Annotated, Literal

from ..base.clock import Rate
from ..base.errors import InputError, RateError
from ..base.toml_table import Table
from ..base.units import ANGLE, FORCE, FREQUENCY, LENGTH, TIME, Bounds
from ..declare import Keys, Names, Open, Rest, Scope, Valid, Value, Wrong
from .marks import At, Name, Pose

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


MOST_CELLS = 250_000
"""Maximum number of bumps of one rough ground."""

_SHORTEST = 0.01  # [m] minimum length and width of a ground, and minimum length of a step
_HIGHEST = 10.0  # [m] maximum height of a ground over the floor
_SIDE = Annotated[float, LENGTH, Bounds(_SHORTEST, 1e3)]
_FORCE = Annotated[float, FORCE, Bounds(-1e5, 1e5)]


def _without_slash(name: str) -> bool:
    return "/" not in name


_WHOLE = Valid(_without_slash, "a valid name of a ground: it contains '/'", "Use another character.")


class GroundSpec(Value):
    """One `[[ground]]` table: a rectangle of the floor that is not level. Only its side faces are obstacles.

    Attributes:
        name: Name without `/`, which also seeds the bumps of rough ground.
        kind: Random bumps, a plane that rises along its length, or one or more steps that rise along it.
        pose: Centre of the rectangle, world frame; the length is along its x axis.
        length, width: Size of the rectangle [m].
        height: Height of the highest bump, of the end of the slope, or of each step [m].
        grain: Distance of neighbouring bumps [m].
        count: Number of steps.
    """

    name: Annotated[Name, _WHOLE]
    kind: Literal["rough", "slope", "step"]
    pose: Pose
    length: _SIDE
    width: _SIDE
    height: Annotated[float, LENGTH, Bounds(1e-4, _HIGHEST)]
    grain: Annotated[float, LENGTH, Bounds(0.005, 100.0)] = 0.1
    count: Annotated[int, Bounds(1, 100)] = 1

    @classmethod
    def _prepare(cls, table: Table, scope: Scope) -> None:
        """Note the faults of keys of another kind."""
        kind = table.data.get("kind")
        for key, owner in (("grain", "rough"), ("count", "step")):
            if key in table and isinstance(kind, str) and kind != owner:
                table.fault(key, f"a ground of the kind '{kind}' has no '{key}'.", f"Only the kind '{owner}' has.")

    def _check(self) -> Iterator[Wrong]:
        """Faults of sizes that do not fit each other."""
        cells, step, rise = self.length * self.width / self.grain**2, self.length / self.count, self.height * self.count
        if self.kind == "rough" and cells > MOST_CELLS:
            yield Wrong(
                "grain", f"the ground has {cells:.0f} bumps; the maximum is {MOST_CELLS}.", "Use a coarser grain."
            )
        if step < _SHORTEST:
            message = f"the steps are {1e3 * step:.3g} mm long; the minimum is {1e3 * _SHORTEST:g} mm."
            yield Wrong("count", message, "Use fewer steps or a greater length.")
        if rise > _HIGHEST * (1.0 + 1e-9):
            message = f"the steps rise to {rise:.3g} m; the maximum is {_HIGHEST:g} m."
            yield Wrong("count", message, "Use fewer or lower steps.")


class ForceKeys(Value):
    """Keys of a force.

    Attributes:
        forward, left, up: Its parts, horizontal frame of the base [N].
    """

    forward: _FORCE = 0.0
    left: _FORCE = 0.0
    up: _FORCE = 0.0

    def _made(self) -> tuple[float, float, float]:
        """The force."""
        return self.forward, self.left, self.up


class PushSpec(Value):
    """One `[[push]]` table: a force on a robot's base for a short time.

    Attributes:
        robot: Name of the agent or actor.
        at: Time of the push, or earliest time [s].
        until: Latest time of the push [s]; the time is sampled uniformly with the seed. None for `at`.
        force: Force [N] forward, to the left and up, horizontal frame of the base.
        duration: Duration of the push [s].
        spread: Largest angle to either side by which the force is turned about the vertical [rad]; the angle is
            sampled uniformly with the seed.
    """

    robot: Annotated[str, Names("robot", "no agent or robot")]
    at: At
    until: At | None = None
    force: Annotated[tuple[float, float, float], Keys(ForceKeys)]
    duration: Annotated[float, TIME, Bounds(1e-3, 60.0)] = 0.1
    spread: Annotated[float, ANGLE, Bounds(0.0, math.pi)] = 0.0

    @property
    def latest(self) -> float:
        """Latest time of the push [s]."""
        return self.at if self.until is None else self.until

    def _check(self) -> Iterator[Wrong]:
        """Faults of times that do not fit each other, and of a force that is none."""
        if self.latest < self.at:
            message = f"the latest time of the push, {self.latest:g} s, is before its earliest, {self.at:g} s."
            yield Wrong("until", message)
        if not any(self.force):
            yield Wrong("force", "the push has no force.", 'Write force = { left = "60 N" }.')
