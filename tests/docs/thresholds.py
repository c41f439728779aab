"""Writes the table of thresholds by robot into rules/README.md: `python tests/docs/thresholds.py`."""

from __future__ import annotations

from pathlib import Path

from rocs_bt.catalog import Catalog
from rocs_bt.check import fitted_rules

PAGE = Path(__file__).resolve().parents[2] / "rules" / "README.md"
HEAD, END = "<!-- thresholds -->\n", "<!-- end -->"
CONSTANTS = ("latency", "deceleration", "front_sweep", "side_sweep")
THRESHOLDS = ("pace", "stop", "near", "clear", "margin")


def wheeled() -> list[str]:
    """Shipped robots on wheels that have a body in the simulator and are no variants of another robot."""
    catalog = Catalog()
    robots = [catalog.load_robot(entry.name) for entry in catalog.list("robot")]
    return [robot.name for robot in robots if not robot.bases and "axes" not in robot.locomotion.parameters]


def page() -> str:
    """The page with the present table."""
    catalog, columns = Catalog(), (*CONSTANTS, *THRESHOLDS)
    before, _, rest = PAGE.read_text("utf-8").partition(HEAD)
    rows = [f"| robot | {' | '.join(f'`{name}`' for name in columns)} |", "|" + "---|" * (1 + len(columns))]
    for robot in wheeled():
        ((_, rules),) = fitted_rules(catalog.find("rules", "avoid_collision"), catalog, robot)
        values = [f"{rules.thresholds[name]:.3g} {rules.dimensions[name]}" for name in columns]
        rows.append(f"| `{robot}` | {' | '.join(values)} |")
    return before + HEAD + "".join(f"{row}\n" for row in rows) + END + rest.partition(END)[2]


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
