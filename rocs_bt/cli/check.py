"""`rocs-bt check`: content files, all faults at once."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path
from typing import Any

import click

from ..errors import Fault


@click.command()
@click.argument("paths", nargs=-1, type=click.Path(path_type=Path))
@click.option("--json", "as_json", is_flag=True, help="As JSON: files, and faults with file, line and column.")
@click.option("--no-code", is_flag=True, help="Load no Python content; parse it only.")
def command(paths: tuple[Path, ...], as_json: bool, no_code: bool) -> int:
    """Check files, and folders with all that is in them; the project around the current folder if none is given.

    Exits with 2 when anything cannot run; a warning alone is no fault.
    """
    from ..check import check_content

    findings = check_content(paths, code=not no_code)
    if as_json:
        plain = {"files": [str(f) for f in findings.files], "faults": [_plain(f) for f in findings.faults]}
        click.echo(json.dumps(plain, indent=2))
        return 2 if findings.wrong else 0
    for fault in findings.faults:
        click.echo(str(fault), err=True)
    wrong = sum(not f.warning for f in findings.faults)
    warnings = len(findings.faults) - wrong
    count = f"{len(findings.files)} file{'' if len(findings.files) == 1 else 's'}"
    click.echo(
        f"{count} checked: {wrong} wrong, {warnings} doubtful." if findings.faults else f"{count} checked: fine."
    )
    return 2 if findings.wrong else 0


def _plain(fault: Fault) -> dict[str, Any]:
    return {**dataclasses.asdict(fault), "file": None if fault.file is None else str(fault.file)}
