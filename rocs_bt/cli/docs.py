"""`rocs-bt docs`: open the manual in the browser, without a network."""

from __future__ import annotations

import webbrowser
from pathlib import Path

import click

from ..base.errors import Fault, InputError
from .terminal import echo

_PACKAGE = Path(__file__).resolve().parent.parent


@click.command()
@click.option("--path", "only_path", is_flag=True, help="Print the path of the manual; do not open it.")
def command(only_path: bool) -> None:
    """Open the manual in the browser; it needs no network."""
    page = find_manual()
    if page is None:
        hint = "Install a wheel of rocs_bt, or run it in a checkout."
        raise InputError(Fault("the manual is not in this installation of rocs_bt.", hint=hint))
    if only_path or not webbrowser.open(page.as_uri()):
        echo(str(page))


def find_manual() -> Path | None:
    """First page of the manual; None if it is missing.

    It is in the installed package, or as `make docs` built it in a checkout, or a page of the checkout in Markdown.
    """
    root = _PACKAGE.parent
    pages = (_PACKAGE / "_manual" / "index.html", root / "build" / "manual" / "index.html", root / "docs" / "index.md")
    return next((page for page in pages if page.is_file()), None)
