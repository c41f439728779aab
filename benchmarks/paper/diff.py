"""`python -m benchmarks.paper.diff FIRST SECOND`: compare the content, settings and code of two scenarios."""

from __future__ import annotations

import dataclasses
import json
import sys
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import click

from rocs_bt.base.errors import InputError
from rocs_bt.cli.content import catalog_for, no_code_option
from rocs_bt.cli.terminal import echo, show_table, styled

if TYPE_CHECKING:
    from .reuse import Counterpart, Reuse, Share
    from .settings import Setting

Rows = list[Sequence[str]]
_NONE = "–"
_NAMES = ("robot", "mission", "rules", "script")  # settings that are always listed in Markdown


@click.command()
@click.argument("first")
@click.argument("second")
@click.option("--json", "as_json", is_flag=True, help="As JSON, with content hashes.")
@click.option("--markdown", is_flag=True, help="As Markdown: differences, and the names of equal settings.")
@no_code_option
def command(first: str, second: str, as_json: bool, markdown: bool, no_code: bool) -> None:
    """List common and differing content, settings and code of the scenarios FIRST and SECOND.

    Content is compared byte by byte; settings are all keys of the scenarios. Code means the classes of the built
    agents; nothing is run.
    """
    from .reuse import diff

    catalog = catalog_for(first, no_code=no_code)
    found = diff(catalog.load_scenario(first), catalog.load_scenario(second), catalog)
    if as_json:
        echo(json.dumps(dataclasses.asdict(found), indent=2))
        return
    for i, (title, rows) in enumerate(_tables(found, brief=markdown)):
        if i:
            echo()
        if markdown:
            echo(_markdown(title, rows))
        else:
            _show(title, rows)


def _tables(found: Reuse, *, brief: bool) -> Iterator[tuple[str, Rows]]:
    """Titles and rows of the tables; the first row is the head."""
    first, second = found.first, found.second
    yield f"Content of {first} and {second}", _shares(found.content, first, second)
    yield f"Settings of {first} and {second}", _settings(found.settings, found, brief=brief)
    for robot in found.robots:
        yield _title(robot, found), _robot(robot, found, brief=brief)
    code = _differences if brief else _shares
    yield f"Engine classes of the agents in {first} and {second}", code(found.code, first, second, "package")
    if not brief:
        yield "Files", _files(found)


def _title(robot: Counterpart, found: Reuse) -> str:
    if not robot.second:
        return f"{robot.first} of {found.first} has no counterpart"
    if not robot.first:
        return f"{robot.second} of {found.second} is new"
    return f"{robot.first} of {found.first}, {robot.second} of {found.second}"


def _robot(robot: Counterpart, found: Reuse, *, brief: bool) -> Rows:
    rows = _settings(robot.settings, found, brief=brief)
    if robot.first and robot.second and robot.code:
        both = sum(len(share.both) for share in robot.code)
        own = [", ".join(n for s in robot.code for n in getattr(s, side)) for side in ("first", "second")]
        what = "engine classes" if brief else f"{both} engine classes, and"
        rows.append((what, *(names or _NONE for names in own), "differs" if any(own) else "same"))
    return rows


def _settings(settings: Sequence[Setting], found: Reuse, *, brief: bool) -> Rows:
    """Rows of the settings; if brief, equal settings share one row."""
    rest = [s.what for s in settings if brief and s.same and s.what not in _NAMES]
    rows: Rows = [("", found.first, found.second, "")]
    rows += (
        (s.what, s.first or _NONE, s.second or _NONE, "same" if s.same else "differs")
        for s in settings
        if s.what not in rest
    )
    if rest:
        rows.append((", ".join(rest), "", "", "same"))
    return rows


def _shares(shares: Sequence[Share], first: str, second: str, head: str = "") -> Rows:
    changed = any(share.changed for share in shares)
    columns = ("both", *(("changed",) if changed else ()), "first", "second")
    heads = {"both": "in both", "changed": "changed", "first": f"only in {first}", "second": f"only in {second}"}
    rows: Rows = [(head, *(heads[column] for column in columns))]
    rows += ((share.kind, *(", ".join(getattr(share, column)) or _NONE for column in columns)) for share in shares)
    return rows


def _differences(shares: Sequence[Share], first: str, second: str, head: str) -> Rows:
    """Rows of the packages that differ; equal packages share the last row."""
    rows: Rows = [(head, f"only in {first}", f"only in {second}")]
    rows += ((s.kind, ", ".join(s.first) or _NONE, ", ".join(s.second) or _NONE) for s in shares if not s.same)
    rows.append((", ".join(s.kind for s in shares if s.same), _NONE, _NONE))
    return rows


def _files(found: Reuse) -> Rows:
    rows: Rows = [("", "", "lines", "sha256")]
    for piece in dict.fromkeys([*found.pieces["first"], *found.pieces["second"]]):
        rows.append((piece.kind, piece.name, str(piece.lines), piece.content_hash[:12]))
    return rows


def _markdown(title: str, rows: Rows) -> str:
    lines = ["| " + " | ".join(" ".join(cell.split()).replace("|", "\\|") for cell in row) + " |" for row in rows]
    rule = "|" + "---|" * len(rows[0])
    return "\n".join([f"**{title}**", "", lines[0], rule, *lines[1:]])


def _show(title: str, rows: Rows) -> None:
    """Print a table, at most as wide as the terminal."""
    head, *body = rows
    colours = {"same": "green", "differs": "yellow"}
    styles = {i: colours[row[-1]] for i, row in enumerate(body) if row[-1] in colours}
    echo(styled(title, bold=True))
    show_table(body, head, styles=styles, indent=2, box=None, pad_edge=False, padding=(0, 2, 0, 0), header_style="dim")


def main(words: Sequence[str] | None = None) -> int:
    """Compare two scenarios; returns the exit code."""
    try:
        command.main(words, prog_name="python -m benchmarks.paper.diff", standalone_mode=False)
    except InputError as error:
        echo(str(error), err=True)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
