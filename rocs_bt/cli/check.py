"""`rocs-bt check`: check content files, with all faults at once."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..base.errors import Fault
from ..base.words import counted
from ..interfaces.vocabulary import dialects
from .content import json_option
from .terminal import echo

if TYPE_CHECKING:
    from ..check import Findings


@click.command()
@click.argument("paths", nargs=-1, type=click.Path(path_type=Path))
@json_option("Print JSON: files, and faults with file, line and column.")
@click.option("--strict", is_flag=True, help="Exit with 2 for warnings too (for CI); notes do not count.")
@click.option("--no-code", is_flag=True, help="Parse Python content without running it.")
@click.option(
    "--nodes",
    "dialect",
    type=click.Choice(dialects()),
    help="XML missions: dialect of the nodes; by default that of the scenarios that use them, or as recognised.",
)
@click.option(
    "--palette",
    "palettes",
    multiple=True,
    type=click.Path(path_type=Path, dir_okay=False),
    help="XML missions: file with a TreeNodesModel of further nodes; may be repeated.",
)
@click.option(
    "--stub-unknown", is_flag=True, help="XML missions: warnings instead of errors for unknown nodes and trees."
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
    """Check files and folders; by default the project that contains the current folder.

    Prints each fault as FILE:LINE:COLUMN: MESSAGE, and a summary, to stdout. Exits with 2 if there are errors, with
    --strict also for warnings, and with 3 on a defect of rocs_bt.

    Behaviour trees and MJCF models may be in any folder: XML files are recognised by their content. A SubTree may name
    a tree of another checked file.
    """
    from ..check import check_content

    findings = check_content(
        paths,
        code=not no_code,
        dialect=dialect or "",
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
