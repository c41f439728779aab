"""The studio of a project: its content and its runs, as routes of the server."""

from __future__ import annotations

from pathlib import Path

import msgspec

from ..base.errors import Fault, InputError
from ..catalog import Catalog, copy_content
from .authoring import edit_routes
from .editing.worker import Worker
from .launch import Launcher, Play, Start, stored_episodes
from .pack import Json
from .requests import Answer, Request, Routes, as_json
from .runs import Runs
from .site import command_of, stream, web_routes


class _Copy(msgspec.Struct, forbid_unknown_fields=True):
    """Shipped content that a person wants in the project."""

    kind: str
    name: str


_KINDS = ("scenario", "mission", "rules", "robot")


def _refuse_python(catalog: Catalog, wanted: _Copy) -> None:
    """Refuse a copy that would write Python files."""
    path = catalog.find(wanted.kind, wanted.name).path
    if path.suffix == ".py" or (wanted.kind == "robot" and any(path.parent.rglob("*.py"))):
        hint = f"Start it with --allow-code, or write: rocs-bt new {wanted.name} --kind {wanted.kind} --copy"
        raise InputError(Fault(f"'{wanted.name}' has Python files, which this studio may not write.", hint=hint))


def project_routes(
    catalog: Catalog, runs: Runs, launcher: Launcher, worker: Worker, *, allow_code: bool = False
) -> Routes:
    """Routes of the studio: the first view, each run, and the editor."""

    def copy(request: Request) -> Answer:
        wanted = request.read(_Copy)
        if not allow_code:
            _refuse_python(catalog.fresh(), wanted)
        return as_json({"file": _place(copy_content(catalog.fresh(), wanted.kind, wanted.name), catalog)})

    def stop(request: Request) -> Answer:
        launcher.stop(_run(request))
        return as_json({})

    def control(request: Request) -> Answer:
        launcher.control(_run(request), command_of(request))
        return as_json({})

    return {
        **web_routes({"": "home", "run": "run"}),
        **edit_routes(catalog, worker, allow_code=allow_code),
        ("GET", "project"): lambda _: as_json(_project(catalog.fresh(), runs)),
        ("GET", "runs"): lambda _: as_json(runs.list()),
        ("GET", "head"): lambda request: runs.head(_run(request), whole="whole" in request.query),
        ("GET", "events"): lambda request: stream(runs.feed(_run(request))),
        ("GET", "output"): lambda request: as_json(launcher.output(_run(request))),
        ("GET", "episodes"): lambda _: as_json(_episodes(runs)),
        ("POST", "start"): lambda request: as_json({"run": launcher.start(request.read(Start))}),
        ("POST", "play"): lambda request: as_json({"run": launcher.play(request.read(Play))}),
        ("POST", "copy"): copy,
        ("POST", "stop"): stop,
        ("POST", "control"): control,
    }


def _run(request: Request) -> str:
    """Name of the run in the address of a request; raises InputError."""
    if not (name := request.query.get("run", "")):
        raise InputError("the address has no run: add ?run=NAME.")
    return name


def _project(catalog: Catalog, runs: Runs) -> Json:
    """Name and content of the project; the project's own first."""
    folder = catalog.project or runs.folder.parent
    content = {kind: _entries(catalog, kind) for kind in _KINDS}
    own = any(entry["own"] for entries in content.values() for entry in entries)
    return {
        "name": folder.name,
        "folder": str(folder),
        "own": own,
        "writable": catalog.project is not None,
        "content": content,
    }


def _episodes(runs: Runs) -> list[Json]:
    """Episodes of comparisons, each with the name of its run if it is recorded."""
    recorded = {run["name"] for run in runs.list()}
    return [
        {**msgspec.to_builtins(play), "outcome": each.outcome, "reason": each.reason, "t": each.sim_time}
        | ({"run": play.folder} if play.folder in recorded else {})
        for play, each in stored_episodes(runs.folder).items()
    ]


def _entries(catalog: Catalog, kind: str) -> list[Json]:
    found = sorted(catalog.list(kind), key=lambda entry: (entry.origin != "project", entry.name))
    return [
        {"name": e.name, "doc": e.doc, "own": e.origin == "project", "file": _place(e.path, catalog)} for e in found
    ]


def _place(path: Path, catalog: Catalog) -> str:
    """Path within the project, or within the shipped content."""
    root = next((root for root in catalog.roots if path.is_relative_to(root)), path.parent)
    return path.relative_to(root).as_posix()
