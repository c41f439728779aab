"""docs/ros2.md: its files make a project that `rocs-bt check` accepts."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest

from rocs_bt.catalog import Catalog
from rocs_bt.check import check_content

PAGE = Path(__file__).resolve().parents[2] / "docs" / "ros2.md"
BLOCKS: list[str] = re.findall(r"```toml\n(.*?)```", PAGE.read_text("utf-8"), re.DOTALL)


def write_project(folder: Path) -> None:
    """Write the files of the page whose first line is their name."""
    for block in BLOCKS:
        if named := re.match(r"# (\S+\.toml)\n", block):
            (file := folder / named[1]).parent.mkdir(parents=True)
            file.write_text(block)


def test_the_files_of_the_page_have_no_faults(tmp_path: Path) -> None:
    write_project(tmp_path)
    files = sorted(tmp_path.rglob("*.toml"))
    assert [file.name for file in files] == ["robot.toml", "my_mission.toml"]
    assert check_content([*files]).faults == ()


@pytest.mark.parametrize("block", [b for b in BLOCKS if not b.startswith("# ")], ids=lambda b: b.split()[0])
def test_each_other_block_fits_into_the_robot_of_the_page(tmp_path: Path, block: str) -> None:
    write_project(tmp_path)
    if "base" not in tomllib.loads(block):
        block = f'format = "robot/3"\nbase = "my_robot"\ndoc = "With a block of the page."\n{block}'
    file = tmp_path / "robots" / "other" / "robot.toml"
    file.parent.mkdir()
    file.write_text(block)
    assert check_content([file]).faults == ()
    assert "ros2" in Catalog(tmp_path).load_robot("other").tables
