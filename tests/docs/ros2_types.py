"""Writes the table of short forms into docs/ros2.md: `python tests/docs/ros2_types.py`."""

from __future__ import annotations

from pathlib import Path

from rocs_bt.drivers.ros2.parameters import TAKES

PAGE = Path(__file__).resolve().parents[2] / "docs" / "ros2.md"
HEAD = "<!-- takes -->\n| type | `take` (number of values) |\n|---|---|\n"
END = "<!-- end -->"
DECLARED = {"ranges": "`rays`", "velocity": "`joints`", "position": "`joints`", "effort": "`joints`"}


def page() -> str:
    """The page with the present table."""
    before, _, rest = PAGE.read_text("utf-8").partition(HEAD)
    rows = []
    for name, takes in TAKES.items():
        forms = ", ".join(f"`{take}` ({DECLARED[take] if size is None else size})" for take, size in takes.items())
        rows.append(f"| `{name}` | {forms} |\n")
    return before + HEAD + "".join(rows) + END + rest.partition(END)[2]


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
