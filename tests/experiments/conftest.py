"""EXP1 as it is shipped, and variants of it in a project of one's own."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from rocs_bt.catalog import Catalog

Change = tuple[str, str]


@pytest.fixture(scope="session")
def catalog() -> Catalog:
    return Catalog()


@pytest.fixture
def variant(tmp_path: Path, catalog: Catalog) -> Callable[..., Catalog]:
    """A project whose EXP1 and rules are the shipped ones with some text changed."""

    def make(*changes: Change, rules: Change | None = None) -> Catalog:
        project = tmp_path / "project"
        for kind, name, wanted in (
            ("scenario", "exp1", changes),
            ("rules", "avoid_collision", [rules] if rules else ()),
        ):
            source = catalog.find(kind, name).path
            target = project / source.parent.name / source.name
            target.parent.mkdir(parents=True, exist_ok=True)
            text = source.read_text(encoding="utf-8")
            for old, new in wanted:
                if old not in text:
                    raise AssertionError(f"'{old}' is not in {source}")
                text = text.replace(old, new)
            target.write_text(text, encoding="utf-8")
        for kind in ("planners", "robots"):
            (project / kind).mkdir(exist_ok=True)
        return Catalog(project)

    return make
