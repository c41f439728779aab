"""The command line in this process, and a project as `rocs-bt new` writes it."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

from rocs_bt.cli.main import call

from ..direct_project import drive_straight


@dataclass(frozen=True)
class Told:
    """What a command said: its exit code, stdout and stderr."""

    code: int
    out: str
    err: str

    @property
    def text(self) -> str:
        """All that it said: `check` tells faults on stdout, other commands on stderr."""
        return self.out + self.err


def refused(told: Told, *patterns: str) -> None:
    """Check that input was refused with messages in which these patterns are."""
    assert told.code == 2, told.text
    assert "Traceback" not in told.text
    for pattern in patterns:
        assert re.search(pattern, told.text), told.text


@pytest.fixture
def rocs_bt(capsys, monkeypatch, tmp_path) -> Callable[..., Told]:
    """Runs `rocs-bt` with these arguments, in an empty folder unless the test has chosen another."""
    monkeypatch.chdir(tmp_path)

    def run(*arguments: object) -> Told:
        code = call([str(a) for a in arguments])
        out, err = capsys.readouterr()
        return Told(code, out, err)

    return run


@pytest.fixture
def project(rocs_bt, monkeypatch, tmp_path) -> Path:
    """A new project, and the current folder in it."""
    assert rocs_bt("new", tmp_path / "yard").code == 0
    drive_straight(tmp_path / "yard")
    monkeypatch.chdir(tmp_path / "yard")
    return tmp_path / "yard"
