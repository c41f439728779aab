"""docs/families.md: its family is one, its table has all that we ship."""

from __future__ import annotations

import re
from pathlib import Path

from rocs_bt import Catalog
from rocs_bt.check import check_content
from rocs_bt.compare import load_family

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "families.md").read_text("utf-8")


def test_the_family_on_the_page_makes_scenes_that_check(tmp_path: Path) -> None:
    (code,) = re.findall(r"```python\n((?:(?!```).)*\(Family\):.*?)```", PAGE, re.DOTALL)
    folder = tmp_path / "scenarios" / "families"
    folder.mkdir(parents=True)
    (folder / "one_gap.py").write_text(code)
    family = load_family(Catalog(tmp_path), "one_gap", {"gap": "1.2 m"})
    scene = family.scene(0)
    assert scene.difficulty["length"] >= 6.0
    scene.write(tmp_path)
    found = check_content([tmp_path])
    assert not found.faults, found.faults


def test_the_page_tells_of_every_family() -> None:
    table = "\n".join(line for line in PAGE.splitlines() if line.startswith("|"))
    assert all(f"`{entry.name}`" in table for entry in Catalog().list("family"))
