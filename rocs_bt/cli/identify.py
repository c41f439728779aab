"""`rocs-bt identify`: measure the drive of a robot's model."""

from __future__ import annotations

import dataclasses
import json
from typing import TYPE_CHECKING

import click

from .run import catalog_for
from .terminal import echo

if TYPE_CHECKING:
    from ..simulation.identify import Identified


@click.command()
@click.argument("robot")
@click.option("--json", "as_json", is_flag=True, help="As JSON, SI units.")
@click.option("--no-code", is_flag=True, help="Refuse Python content.")
def command(robot: str, as_json: bool, no_code: bool) -> None:
    """Measure the drive of ROBOT, a name or a file, on an infinite plane, for the values in its robot.toml.

    Effective wheel separation, ICR offset, wheel lag, top speed, and the braking distance by speed. Takes seconds.
    """
    from ..simulation.identify import identify

    catalog = catalog_for(robot, code=not no_code)
    found = identify(catalog.load_robot(robot), catalog)
    echo(json.dumps(dataclasses.asdict(found), indent=2) if as_json else _text(found))


def _text(found: Identified) -> str:
    lines = [
        f"{found.robot} on a plane:",
        f"  effective_wheel_separation  {found.effective_wheel_separation:.3f} m from measured wheel speeds; "
        f"deviation of single turns up to {100.0 * found.wheel_separation_error:.1f} %, "
        f"loss of turn rate under load up to {100.0 * (1.0 - found.slowest_turn):.0f} %",
        f"  icr_offset                  {found.icr_offset:.3f} m ahead of the base, in curves",
        f"  wheel_lag                   {found.wheel_lag:.3f} s on a ramp at the drive's maximum acceleration",
        f"  top speed                   {found.top_speed:.2f} m/s",
        f"  braking                     {found.brake_delay:.3f} s of delay, then {found.deceleration:.2f} m/s2, with a "
        f"fit error up to {100.0 * found.misfit:.1f} %",
        f"  for WheelMonitor            latency: one sensor period plus {found.brake_delay:.3f} s; "
        f"deceleration: {found.deceleration:.2f} m/s2",
        "",
        "  from [m/s]   distance [m]     time [s]",
        *(f"  {b.speed:10.2f}  {b.distance:13.3f}  {b.time:11.2f}" for b in found.braking),
    ]
    return "\n".join(lines)
