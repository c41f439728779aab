"""A project whose robot has sonars and drives straight: a new one, with the robot, mission and rule of the paper."""

import shutil
from pathlib import Path

from rocs_bt.catalog import Catalog

CHANGES = {
    "planners/missions/patrol.py": [
        ('mission.tree("navigate", goal=place, cruise=cruise)', 'mission.act("GoTo", goal=place, cruise=cruise)'),
        (
            "The shipped mission `navigate` drives to each of them: it plans a path in the map that\n"
            "the robot builds from its scans, and plans again as the map grows.\n",
            "The reflex rules avoid obstacles.\n",
        ),
    ],
    "rules/keep_clear.toml": [("0.25 m,", "0.40 m,"), ("0.35 m", "0.50 m"), ("0.24 m", "0.39 m"), ("0.36 m", "0.51 m")],
    "scenarios/first.toml": [('"contact", ', "")],
    "planners/brisk.toml": [('"contact", ', "")],
    "planners/careful.toml": [('"contact", ', "")],
}


def drive_straight(project: Path) -> None:
    """Change a new project."""
    for name, pairs in CHANGES.items():
        text = (project / name).read_text("utf-8")
        for old, new in pairs:
            assert old in text, (name, old)
            text = text.replace(old, new)
        (project / name).write_text(text, "utf-8")
    shutil.rmtree(project / "robots/rover")
    shutil.copytree(Catalog().find("robot", "pioneer_p3dx").path.parent, project / "robots/rover")
