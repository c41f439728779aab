"""`rocs-bt identify`: measure the motion of a robot's model."""

from __future__ import annotations

import difflib
import json
import os
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ..base.errors import Fault, InputError
from ..base.files import check_writable, read_text, write_whole
from ..declare import values_of
from .content import catalog_for, json_option, no_code_option
from .terminal import echo

if TYPE_CHECKING:
    from ..catalog import Catalog, RobotSpec
    from ..simulation.identified_file import IdentifiedFile
    from ..simulation.identify import Identified


@click.command()
@click.argument("robot")
@click.option("--write", is_flag=True, help="Correct robot.toml where it differs in a harmful direction.")
@json_option("As JSON, SI units.")
@click.option("--dry-run", is_flag=True, help="Write no file.")
@no_code_option
def command(robot: str, write: bool, as_json: bool, dry_run: bool, no_code: bool) -> None:
    """Measure the motion of ROBOT, a name or a file, on an infinite plane, and write identified.toml beside robot.toml.

    For each axis of the body twist: reached speed, lag, and stopping distance; for wheels on two sides also effective
    wheel separation and ICR offset. `rocs-bt check` compares robot.toml with the file. Takes seconds.

    With --write, values of [locomotion] of which check would warn are corrected in robot.toml, and the changed lines
    are printed; margins and comments stay.
    """
    from ..catalog import IDENTIFIED
    from ..simulation.identified_file import identified_text, read_identified
    from ..simulation.identify import identify

    catalog = catalog_for(robot, no_code=no_code)
    spec = catalog.load_robot(robot)
    if write:
        _refuse_unwritable(spec.file, catalog)
    before = read_text(spec.file, raw=True)
    found = identify(spec, catalog)
    twists = not spec.motion.wheeled
    text = json.dumps(values_of(found), indent=2, default=values_of)
    echo(text if as_json else "\n".join(_text(found, twists=twists)))
    measured, file = identified_text(spec, found.axes, found.wheels), spec.file.parent / IDENTIFIED
    after = _corrected(spec, before, read_identified(file, measured)) if write else before
    if not as_json and write:
        echo("\n" + (_diff(spec.file, before, after) or f"{spec.file} needs no correction."))
    if dry_run:
        return
    _write(file, measured)
    if after != before:
        if read_text(spec.file, raw=True) != before:
            raise InputError(Fault("the file was changed during the measurement.", spec.file, hint="Call this again."))
        _write(spec.file, after)
    if not as_json:
        echo(f"\nWritten to {file}; `rocs-bt check {file.parent}` compares robot.toml with it.")


def _refuse_unwritable(file: Path, catalog: Catalog) -> None:
    """Refuse a robot.toml of rocs_bt itself, or one that is read-only."""
    from ..catalog import find_project

    mine = (find_project(Path.cwd()) or Path.cwd()) / "robots" / file.parent.name
    copy = f'Write a robot of your own with base = "{file.parent.name}", or copy this one: cp -r {file.parent} {mine}'
    if file.resolve().is_relative_to(catalog.shipped):
        raise InputError(Fault("the robot is shipped with rocs_bt, and is not changed.", file, hint=copy))
    try:
        check_writable(file.resolve())
        writable = file.stat().st_mode & 0o222 != 0 and os.access(file, os.W_OK)
    except OSError:
        writable = False
    if not writable:
        raise InputError(Fault("the file is read-only.", file, hint=f"Make it writable. {copy}"))


def _corrected(spec: RobotSpec, text: str, measured: IdentifiedFile) -> str:
    from ..base.toml_edit import with_values
    from ..base.toml_text import Key
    from ..check.identified import as_quantities, corrections

    values = as_quantities(corrections(spec, measured)).items()
    keys: dict[Key, str] = {("locomotion", *key.split(".")): value for key, value in values}
    return with_values(text, keys, spec.file, "measured by rocs-bt identify")


def _diff(file: Path, before: str, after: str) -> str:
    lines = before.splitlines(), after.splitlines()
    return "\n".join(difflib.unified_diff(*lines, str(file), str(file), n=1, lineterm=""))


def _write(file: Path, text: str) -> None:
    try:
        write_whole(file, text)
    except OSError as error:
        hint = "Copy the robot's folder into your project, or use --dry-run."
        raise InputError(Fault(f"cannot write the file: {error.strerror or error}.", file, hint=hint)) from error


def _text(found: Identified, *, twists: bool) -> Iterator[str]:
    yield f"{found.robot} on a plane:"
    yield ""
    yield "  axis   max_speed       lag  latency  deceleration  stop distance  fit error"
    for axis, of in found.axes.items():
        m = "rad" if axis == "wz" else "m"
        latency = "-" if of.latency is None else _with_unit(of.latency, 3, "s")
        deceleration = "-" if of.deceleration is None else _with_unit(of.deceleration, 2, f"{m}/s2")
        yield (
            f"  {axis:4}{_with_unit(of.max_speed, 2, f'{m}/s'):>12}  {max(of.lag, 0.0):6.3f} s{latency:>9}"
            f"{deceleration:>14}{_with_unit(of.stop_distance, 3, m):>15}  up to {100.0 * of.misfit:.1f} %"
        )
    yield ""
    if bad := [axis for axis, of in found.axes.items() if of.latency is None]:
        yield f"  Latency and deceleration do not describe the braking along {', '.join(bad)}: the stop distance is the"
        yield "  longest that was measured, scaled to max_speed."
    yield "  lag: behind a ramp at the maximum acceleration, or that of braking wheels; delay + lag in robot.toml."
    yield "  latency: delay until braking begins; latency in robot.toml is one sensor period more."
    if twists:
        yield "  deceleration: depends on the declared one (the gate permits 1.5 times it); declare what can be held."
    yield "  stop distance: from max_speed, by latency and deceleration."
    if found.wheels is not None:
        wheels = found.wheels
        yield ""
        yield (
            f"  effective_wheel_separation  {wheels.effective_wheel_separation:.3f} m from measured wheel speeds; "
            f"deviation of single turns up to {100.0 * wheels.wheel_separation_error:.1f} %, "
            f"loss of turn rate under load up to {100.0 * (1.0 - wheels.slowest_turn):.0f} %"
        )
        yield f"  icr_offset                  {wheels.icr_offset:.3f} m ahead of the base, in curves"
    yield ""
    yield "  axis        from  distance      time"
    for axis, of in found.axes.items():
        m = "rad" if axis == "wz" else "m"
        for b in of.braking:
            yield f"  {axis:4}{_with_unit(b.speed, 2, f'{m}/s'):>12}{_with_unit(b.distance, 3, m):>10}{b.time:8.2f} s"


def _with_unit(value: float, digits: int, unit: str) -> str:
    return f"{value:.{digits}f} {unit}"
