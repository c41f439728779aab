"""Keeping: a scene that was found becomes an ordinary scenario of a project, and a test of it."""

from __future__ import annotations

import re
from pathlib import Path

from ...errors import Fault, InputError
from ..replay import episode_command
from .draft import Draft
from .player import SEED

_TEST = '''"""A scene in which a search found that {planner} fails. Red until it does not."""

import pytest


@pytest.mark.planners("{planner}")
@pytest.mark.scenarios("{name}")
def {function}(comparison):
    assert comparison.comparison.outcomes("{planner}") == {{"success": 1}}
'''


def refuse_existing(folder: Path, name: str) -> None:
    """Refuse to write over a scenario.

    Raises:
        InputError: The project has one of this name, or it cannot name one.
    """
    if not re.fullmatch(r"\w[\w-]*", name):
        raise InputError(Fault(f"'{name}' cannot name a scenario.", hint="Use letters, digits, '_' and '-'."))
    for file in (folder / "scenarios" / f"{name}.toml", _test_of(name, folder)):
        if file.exists():
            raise InputError(Fault(f"'{name}' is there already.", file, hint="Give another name by --name."))


def keep(draft: Draft, planner: str, folder: Path) -> tuple[Path, Path]:
    """Write a scene and a test of it into a project.

    Args:
        draft: The scene.
        planner: Who fails in it.
        folder: The project.

    Returns:
        The files of the scenario and of the test.
    """
    scenario = draft.scene.write(folder)
    test = _test_of(draft.name, folder)
    test.parent.mkdir(parents=True, exist_ok=True)
    test.write_text(_TEST.format(planner=planner, name=draft.name, function=test.stem), encoding="utf-8")
    return scenario, test


def play_command(draft: Draft, planner: str) -> str:
    """What a person types to play the scene again and look at it."""
    return episode_command(planner, draft.name, SEED)


def _test_of(name: str, folder: Path) -> Path:
    plain = re.sub(r"\W", "_", name)
    return folder / "tests" / f"test_{plain}.py"
