"""`rocs-bt studio`: a project, or a run, in the browser."""

from __future__ import annotations

import getpass
import os
import secrets
import threading
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import quote

import click

from ..base.errors import Fault, InputError
from ..base.files import check_regular
from ..cli.content import no_code_option
from ..cli.terminal import echo, echo_traceback

if TYPE_CHECKING:
    from .requests import Routes
    from .server import Server

PORT = 8765
"""First port that is tried if none is given."""

_TRIES = 20  # ports, before any free one


@click.command()
@click.argument("path", required=False, type=click.Path(path_type=Path))
@click.option("--port", type=click.IntRange(1, 65535), help=f"Port; by default the first free one from {PORT} on.")
@click.option("--no-browser", is_flag=True, help="Open no browser; print the address only.")
@click.option("--allow-code", is_flag=True, help="Let the editor of the page change Python files.")
@no_code_option
def command(path: Path | None, port: int | None, no_browser: bool, allow_code: bool, no_code: bool) -> None:
    """Open a project or a run in the browser: watch, start and control runs, and edit content.

    PATH is the folder of a project, by default that of the current folder, or the folder of a run, or its run.mcap.
    The page is served on this machine only, at an address that contains a secret. Ctrl-C ends it and the runs that it
    has started, in order.
    """
    from ..catalog import Catalog, find_project
    from ..record import Recording
    from .editing.worker import Worker
    from .launch import Launcher
    from .project import project_routes
    from .runs import Runs

    run = _run_of(path)
    if run is not None:
        Recording.open(run)  # says what is wrong before a browser opens
    place = Path.cwd() if path is None else run.parent if run is not None else path
    catalog = Catalog(find_project(place) or place, code=not no_code)
    runs = Runs((catalog.project or place).absolute() / "runs", run)
    routes: Routes = {}
    server = _server(port, routes)
    launcher, worker = Launcher(catalog, runs, server.url), Worker()
    routes.update(project_routes(catalog, runs, launcher, worker, allow_code=allow_code))
    server.start()
    try:
        _open(f"{server.url}{'' if run is None else f'run?run={quote(run.name)}'}", server.port, no_browser)
        threading.Event().wait()
    finally:
        launcher.end()
        worker.close()
        server.end()


def _run_of(path: Path | None) -> Path | None:
    """Folder of the run that a path means; None if it means a project. Raises InputError."""
    if path is None or (path.is_dir() and not (path / "run.mcap").exists()):
        return None
    if not path.is_dir():
        try:
            check_regular(path)
        except OSError as error:
            raise InputError(Fault(f"cannot read '{path}': {error.strerror}.")) from error
    if not path.is_dir() and not (path.is_file() and path.suffix == ".mcap"):
        hint = "Give the folder of a project, the folder of a run, or its run.mcap."
        raise InputError(Fault(f"'{path}' is no project and no run.", hint=hint))
    return (path if path.is_dir() else path.parent).absolute()


def _server(port: int | None, routes: Routes) -> Server:
    """Server on a port, or on the first free one if none is given; raises InputError."""
    from .server import Server

    token = secrets.token_urlsafe(16)
    for each in [port] if port is not None else [*range(PORT, PORT + _TRIES), 0]:
        try:
            return Server("127.0.0.1", each, token, routes, echo_traceback)
        except InputError:
            if each in (port, 0):
                raise
    raise RuntimeError("unreachable")


def _open(url: str, port: int, no_browser: bool) -> None:
    """Print the address, and open it unless the person is at another machine."""
    echo(f"Studio: {url}")
    if connection := os.environ.get("SSH_CONNECTION", "").split():
        host = connection[2] if len(connection) == 4 else "HOST"
        echo("You are connected by ssh. Type on your own machine, then open the address there:")
        echo(f"  ssh -N -L {port}:127.0.0.1:{port} {_user()}@{f'[{host}]' if ':' in host else host}")
    elif not no_browser:
        import webbrowser

        with suppress(webbrowser.Error):
            webbrowser.open(url)
    echo("Ctrl-C ends it.")


def _user() -> str:
    try:
        return getpass.getuser()
    except (OSError, KeyError):  # a user without a name
        return "USER"
