"""`rocs-bt upgrade`: rewrite content files of old formats."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from ..files import write_whole
from ..words import counted
from .terminal import echo

if TYPE_CHECKING:
    from ..catalog import Upgrade


@click.command()
@click.argument("path", required=False, type=click.Path(path_type=Path))
@click.option("--dry-run", is_flag=True, help="Print the changes without writing them.")
def command(path: Path | None, dry_run: bool) -> int:
    """Rewrite robots and scenarios of old formats; PATH is a file or a folder, by default the project.

    Changes the format and renamed keys only; comments, order and spacing stay. Keys of your own drivers and blocks
    stay too. A file that cannot be upgraded is reported and left unchanged; the command then exits with 2.
    """
    from ..catalog import find_project, upgrades
    from ..errors import InputError

    folder = path or find_project(Path.cwd())
    if folder is None:
        raise InputError("there is no project here. Give a file or a folder: rocs-bt upgrade PATH.")
    changed = failed = 0
    for upgrade in upgrades(folder):
        if upgrade.error is None and upgrade.changes and not dry_run:
            try:
                write_whole(upgrade.file, upgrade.text)
            except OSError as error:
                echo(f"{upgrade.file}: cannot write the file: {error.strerror}.")
                failed += 1
                continue
        echo("\n".join(_lines(upgrade)), nl=bool(upgrade.changes or upgrade.notes or upgrade.error))
        changed += bool(upgrade.changes)
        failed += upgrade.error is not None
    done = f"{counted(changed, 'file')} {'to upgrade' if dry_run else 'upgraded'}"
    echo(f"{done}, {failed} left unchanged because of errors." if failed else f"{done}.")
    return 2 if failed else 0


def _lines(upgrade: Upgrade) -> list[str]:
    here, file = Path.cwd(), upgrade.file
    file = file.relative_to(here) if file.is_relative_to(here) else file
    lines = [f"{file}:{c.line}: {c.old} -> {c.new}" for c in upgrade.changes]
    return [*lines, *map(str, upgrade.notes), *([] if upgrade.error is None else [str(upgrade.error)])]
