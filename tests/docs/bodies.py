"""Tables of docs/bodies.md: `python tests/docs/bodies.py` plays EXP1 on all bodies and writes them (20 min)."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

from click.testing import CliRunner

from rocs_bt.catalog import Catalog
from rocs_bt.cli.main import group

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "bodies.md"
_ROBOTS = re.compile(r"(<!-- (campaign.py [^>]*) -->\n).*?(<!-- end -->)", re.DOTALL)
_COMPARED = re.compile(r"(```console\n\$ rocs-bt (compare .*?)\n).*?(```)", re.DOTALL)
HEAD = """\
| robot | drive | body | clean | exact 95 % interval | collisions | falls | late | other | median time | \
minimum clearance |
|---|---|---|---|---|---|---|---|---|---|---|
"""


def bodies() -> list[str]:
    """The simulated robots that have a body of their own, by the kind of their drive."""
    catalog = Catalog()
    robots = [catalog.load_robot(entry.name) for entry in catalog.list("robot")]
    own = [robot for robot in robots if not robot.bases]
    return [robot.name for robot in sorted(own, key=lambda robot: (robot.locomotion.kind, robot.name))]


def row(name: str, command: str) -> str:
    """The line of a robot, from its campaign."""
    script = ROOT / "tests" / "experiments" / command.split()[0]
    options = [*command.split()[1:], "--robot", name, "--json"]
    done = subprocess.run([sys.executable, script, *options], check=True, capture_output=True, text=True)
    found = json.loads(done.stdout)["agents"]["R2"]
    robot, clean = Catalog().load_robot(name), found["clean"]
    late = sum(run["outcome"] in ("timeout", "success") for run in found["failed"])
    counts = [found["collided"]["count"], found["fell"]["count"], late]
    cells = (
        f"`{name}`",
        robot.locomotion.kind,
        f"{robot.length:.2f} m x {robot.width:.2f} m",
        f"{clean['count']} of {clean['of']}",
        f"{100.0 * clean['interval'][0]:.1f} to {100.0 * clean['interval'][1]:.1f} %",
        *map(str, counts),
        str(clean["of"] - clean["count"] - sum(counts)),  # stuck or failed
        f"{found['median_time']:.1f} s",
        f"{1000.0 * found['least_clearance']:.0f} mm",
    )
    return f"| {' | '.join(cells)} |\n"


def written(text: str, store: Path) -> str:
    """The page with every table as its command gives it now; episodes of the comparison are kept in a store."""

    def robots(found: re.Match[str]) -> str:
        return found[1] + HEAD + "".join(row(name, found[2]) for name in bodies()) + "\n" + found[3]

    def compared(found: re.Match[str]) -> str:
        done = CliRunner().invoke(group, [*found[2].split(), "--store", str(store)], catch_exceptions=False)
        table = done.output.partition("\n\n")[2]  # after the line of episodes, which depends on the store
        return f"{found[1]}\n{table.rstrip()}\n{found[3]}"

    return _COMPARED.sub(compared, _ROBOTS.sub(robots, text))


if __name__ == "__main__":
    PAGE.write_text(written(PAGE.read_text("utf-8"), ROOT / "build" / "bodies"), "utf-8")
