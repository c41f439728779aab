"""`rocs-bt docs` finds a first page in every kind of installation, also in a checkout without a built manual."""

from __future__ import annotations

from pathlib import Path

import pytest

from rocs_bt.cli import docs
from rocs_bt.cli.main import call


@pytest.mark.parametrize("page", ["rocs_bt/_manual/index.html", "build/manual/index.html", "docs/index.md"])
def test_the_manual_is_found(
    page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(docs, "_PACKAGE", tmp_path / "rocs_bt")
    assert call(["docs", "--path"]) == 2
    assert "the manual is not in this installation" in capsys.readouterr().err
    (tmp_path / page).parent.mkdir(parents=True)
    (tmp_path / page).touch()
    assert call(["docs", "--path"]) == 0
    assert capsys.readouterr().out == f"{tmp_path / page}\n"


def test_the_manual_of_this_checkout_is_found(capsys: pytest.CaptureFixture[str]) -> None:
    assert call(["docs", "--path"]) == 0
    assert Path(capsys.readouterr().out.strip()).is_file()
