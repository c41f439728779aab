"""`rocs-bt knowledge`: what agents knew over a run, and know for the next one."""

from __future__ import annotations

import click

from .knowledge_files import export, show, take
from .knowledge_query import query
from .knowledge_why import why


@click.group()
def command() -> None:
    """Look into what agents knew: ask, draw, write and read it."""


for each in (query, why, show, export, take):
    command.add_command(each)
