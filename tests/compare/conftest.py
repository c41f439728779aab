"""Short scenarios, and planners made of nothing."""

from __future__ import annotations

from pathlib import Path

import pytest

from rocs_bt.catalog import Catalog


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """A project with EXP1 that ends after two seconds, named 'short', and a folder for planners."""
    text = Catalog().find("scenario", "exp1").path.read_text("utf-8")
    (tmp_path / "scenarios").mkdir()
    (tmp_path / "scenarios" / "short.toml").write_text(text.replace('"60 s"', '"2 s"'), "utf-8")
    (tmp_path / "planners").mkdir()
    return tmp_path


@pytest.fixture
def catalog(project: Path) -> Catalog:
    """The project's content."""
    return Catalog(project)


@pytest.fixture
def planner(project: Path):
    """Writes a planner whose act is given as Python, and gives its name."""

    def write(name: str, act: str, reset: str = "self.rng = rng", head: str = "", top: str = "") -> str:
        code = (
            f'"""Does as told."""\nimport os\nimport time\n{top}\n\n\nclass Told:\n{head}'
            f"    def reset(self, task, rng):\n        {reset}\n\n    def act(self, observation):\n        {act}\n"
        )
        (project / "planners" / f"{name}.py").write_text(code, "utf-8")
        text = f'format = "planner/1"\ndoc = "Does as told."\npython = "{name}.py:Told"\n'
        (project / "planners" / f"{name}.toml").write_text(text, "utf-8")
        return name

    return write
