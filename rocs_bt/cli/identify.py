"""`rocs-bt identify`: what a robot does when its wheels are told something."""

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
    """Drive the model of ROBOT, a name or a file, on an endless plane, and tell what its robot.toml should say.

    Effective track, pivot, wheel lag, top speed, and the braking distance by speed. Takes seconds.
    """
    from ..simulation.identify import identify

    catalog = catalog_for(robot, code=not no_code)
    found = identify(catalog.load_robot(robot), catalog)
    echo(json.dumps(dataclasses.asdict(found), indent=2) if as_json else _told(found))


def _told(found: Identified) -> str:
    lines = [
        f"{found.robot} on a plane:",
        f"  effective track  {found.effective_track:.3f} m from true rim speeds; single turns stray from it by up to "
        f"{100.0 * found.track_error:.1f} %, and the load costs up to {100.0 * (1.0 - found.slowest_turn):.0f} % of a "
        "commanded turn",
        f"  pivot            {found.pivot:.3f} m ahead of the base, in curves",
        f"  wheel lag        {found.wheel_lag:.3f} s on a ramp at the drive's greatest acceleration",
        f"  top speed        {found.top_speed:.2f} m/s",
        f"  braking          {found.brake_delay:.3f} s of delay, then {found.deceleration:.2f} m/s2, which strays by "
        f"up to {100.0 * found.misfit:.1f} %",
        "",
        "  from [m/s]  stands after [m]   and [s]",
        *(f"  {b.speed:10.2f}  {b.distance:16.3f}  {b.time:8.2f}" for b in found.braking),
    ]
    return "\n".join(lines)
