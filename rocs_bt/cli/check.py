"""`rocs-bt check`: content files, all faults at once."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..errors import Fault
from ..words import counted
from .terminal import echo

if TYPE_CHECKING:
    from ..check import Findings


@click.command()
@click.argument("paths", nargs=-1, type=click.Path(path_type=Path))
@click.option("--json", "as_json", is_flag=True, help="As JSON: files, and faults with file, line and column.")
@click.option("--strict", is_flag=True, help="A warning is a fault, too (for CI); what cannot be decided is none.")
@click.option("--no-code", is_flag=True, help="Load no Python content; parse it only.")
@click.option(
    "--nodes",
    "dialect",
    type=click.Choice(["rocs", "nav2"]),
    help="Of missions in XML: whose nodes they name; what the scenarios that play them say by default.",
)
@click.option(
    "--palette",
    "palettes",
    multiple=True,
    type=click.Path(path_type=Path, dir_okay=False),
    help="Of missions in XML: a file whose TreeNodesModel declares nodes that are not here; may be repeated.",
)
@click.option(
    "--stub-unknown", is_flag=True, help="Of missions in XML: one warning for each unknown node or tree, no errors."
)
def command(
    paths: tuple[Path, ...],
    as_json: bool,
    strict: bool,
    no_code: bool,
    dialect: str | None,
    palettes: tuple[Path, ...],
    stub_unknown: bool,
) -> int:
    """Check files, and folders with all that is in them; the project around the current folder if none is given.

    Faults and their summary go to stdout, each fault as FILE:LINE:COLUMN: MESSAGE. Exits with 2 when anything cannot
    run; a warning alone is no fault, unless it is asked for with --strict. Exits with 3 on a defect of rocs_bt.

    Behaviour trees and MJCF models may stand anywhere: XML files are recognised by what they hold. A SubTree may
    name a tree of another file that is checked with it.
    """
    from ..check import check_content

    findings = check_content(
        paths,
        code=not no_code,
        dialect=None if dialect is None else dialect.removeprefix("rocs"),
        palettes=palettes,
        stub_unknown=stub_unknown,
    )
    code = 2 if findings.has_errors or (strict and findings.has_warnings) else 0
    if as_json:
        plain = {"files": [str(f) for f in findings.files], "faults": [_plain(f) for f in findings.faults]}
        echo(json.dumps(plain, indent=2))
    else:
        for fault in findings.faults:
            echo(fault)
        echo(_summary(findings))
    if findings.defect is not None:
        raise findings.defect
    return code


def _summary(findings: Findings) -> str:
    checked = f"{counted(len(findings.files), 'file')} checked"
    if not findings.faults:
        return f"{checked}: no faults."
    errors = sum(not f.warning for f in findings.faults)
    notes = sum(f.note for f in findings.faults)
    parts = [counted(errors, "error"), counted(len(findings.faults) - errors - notes, "warning")]
    return f"{checked}: {', '.join([*parts, counted(notes, 'note')] if notes else parts)}."


def _plain(fault: Fault) -> dict[str, Any]:
    return {**dataclasses.asdict(fault), "file": None if fault.file is None else str(fault.file)}
