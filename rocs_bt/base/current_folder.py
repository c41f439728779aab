"""The current folder is kept off the path from which Python imports modules.

Otherwise a file such as `struct.py` in the folder of a user is run in place of the module of that name, by this process
or by an interpreter that rocs_bt or a library of it starts. Scripts that a user's own code starts keep their folder.
"""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

_one_at_a_time = threading.RLock()
_OWN = str(Path(__file__).resolve().parents[2])
"""Folder of the package: the current folder too, if a checkout is run in place."""


def keep_current_folder_off_path() -> None:
    """Remove the current folder from the path of this process."""
    sys.path[:] = _without_current_folder(sys.path)


def safe_path() -> dict[str, str]:
    """Environment variables of an interpreter that imports nothing from its current folder.

    Scripts that it starts inherit them and do not see their own folder; an interpreter that runs a user's code gets
    only `PYTHONPATH`, and the option -P.
    """
    # An empty entry is the current folder: `PYTHONPATH=$PYTHONPATH:/other` has one if the variable was unset.
    paths = _without_current_folder(os.environ.get("PYTHONPATH", "").split(os.pathsep))
    return {"PYTHONSAFEPATH": "1", "PYTHONPATH": os.pathsep.join(paths)}


def child_environment() -> dict[str, str]:
    """Environment of an interpreter with option -P that imports this package, and nothing from the current folder."""
    paths = [_OWN, *filter(None, [safe_path()["PYTHONPATH"]])]
    return {**os.environ, "PYTHONPATH": os.pathsep.join(paths)}


def _without_current_folder(paths: Sequence[str]) -> list[str]:
    here = os.getcwd()
    return [each for each in paths if (path := os.path.abspath(each or here)) != here or path == _OWN]


@contextmanager
def environment(values: Mapping[str, str]) -> Iterator[None]:
    """Set environment variables inside the `with` block, for processes that are started there; one block at a time."""
    with _one_at_a_time:
        before = {name: os.environ.get(name) for name in values}
        os.environ.update(values)
        try:
            yield
        finally:
            for name, value in before.items():
                if value is None:
                    del os.environ[name]
                else:
                    os.environ[name] = value
