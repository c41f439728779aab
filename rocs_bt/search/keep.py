"""Save a scene that a search has found as a scenario of a project, with a pytest test."""

from __future__ import annotations

import re
from pathlib import Path

from ..base.errors import Fault, InputError
from ..base.files import is_file, write_whole
from ..compare.replay import episode_command
from .draft import Draft
from .player import SEED

_TEST = '''"""A scene, found by a search, in which {planner} fails. The test fails until the planner is fixed."""

import pytest


@pytest.mark.planners("{planner}")
@pytest.mark.scenarios("{name}")
def {function}(comparison):
    assert comparison.comparison.outcomes("{planner}") == {{"success": 1}}
'''


def refuse_existing(folder: Path, name: str) -> None:
    """Check that saving a scene under a name would not overwrite a file.

    Raises:
        InputError: A file of this name exists, the folder is a file, or the name is not valid for a scenario.
    """
    if is_file(folder):
        raise InputError(Fault(f"'{folder}' is no folder.", hint="Choose another one with --out."))
    if not re.fullmatch(r"\w[\w-]*", name):
        raise InputError(Fault(f"'{name}' is not a valid scenario name.", hint="Use letters, digits, '_' and '-'."))
    for file in (folder / "scenarios" / f"{name}.toml", _test_of(name, folder)):
        if file.exists():
            raise InputError(Fault(f"'{name}' already exists.", file, hint="Choose another name with --name."))


def keep(draft: Draft, planner: str, folder: Path) -> tuple[Path, Path]:
    """Write a scene, and a test that the planner succeeds in it, into a project."""
    scenario = draft.scene.write(folder)
    test = _test_of(draft.name, folder)
    test.parent.mkdir(parents=True, exist_ok=True)
    write_whole(test, _TEST.format(planner=planner, name=draft.name, function=test.stem))
    return scenario, test


def play_command(draft: Draft, planner: str) -> str:
    """Shell command that plays a planner in the saved scene again."""
    return f"{episode_command(planner, draft.name)} --seed {SEED}"


def _test_of(name: str, folder: Path) -> Path:
    plain = re.sub(r"\W", "_", name)
    return folder / "tests" / f"test_{plain}.py"
