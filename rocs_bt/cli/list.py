"""`rocs-bt list`: list all content."""

from __future__ import annotations

import json

import click

from ..catalog import KINDS, Catalog, Entry
from .content import json_option
from .terminal import echo, styled


@click.command()
@click.argument("kind", required=False)
@json_option("As JSON: name, kind, path, doc, origin.")
def command(kind: str | None, as_json: bool) -> None:
    """List the content of the project and of rocs_bt, by kind and name.

    KIND is a kind of content, such as scenario or rules, or its plural.
    """
    entries = Catalog.here().list(_singular(kind))
    if as_json:
        echo(json.dumps([_plain(e) for e in entries], indent=2))
        return
    width = max((len(e.name) for e in entries), default=0)
    for found in KINDS:
        of_kind = [e for e in entries if e.kind == found]
        if of_kind:
            echo(styled(found, bold=True))
        for e in of_kind:
            origin = " (project)" if e.origin == "project" else ""
            echo(f"  {e.name:<{width}}  {e.doc}{origin}")
    if not entries:
        echo("None found.")


def _singular(kind: str | None) -> str | None:
    if kind is None or kind in KINDS:
        return kind
    if kind == "families":
        return "family"
    return kind[:-1] if kind.endswith("s") and kind[:-1] in KINDS else kind


def _plain(entry: Entry) -> dict[str, str]:
    return {
        "name": entry.name,
        "kind": entry.kind,
        "path": str(entry.path),
        "doc": entry.doc,
        "origin": entry.origin,
    }
