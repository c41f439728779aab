"""Write the generated parts of pages: `python docs/tables.py [PAGE ...]`; all pages but bodies.md by default.

For bodies.md it plays EXP1 on all bodies, which takes 20 min.
"""

from __future__ import annotations

import inspect
import json
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

from click.testing import CliRunner

from rocs_bt import Pose2, Twist2
from rocs_bt.actions import ACTIONS
from rocs_bt.catalog import Catalog
from rocs_bt.check import fitted_rules
from rocs_bt.cli.main import group
from rocs_bt.declare import docs_of
from rocs_bt.interfaces.action import Action, parameters_of
from rocs_bt.plan import Observation, Task, Vehicle
from rocs_bt.ros2.messages.message_types import MESSAGES

ROOT = Path(__file__).resolve().parent.parent
PLANNER_CLASSES = (Task, Observation, Pose2, Twist2, Vehicle)
_CONSTANTS = ("latency", "deceleration", "front_sweep", "side_sweep")
_THRESHOLDS = ("pace", "stop", "near", "clear", "margin")
_CAMPAIGNS = re.compile(r"(<!-- (campaign.py [^>]*) -->\n).*?(<!-- end -->)", re.DOTALL)
_COMPARED = re.compile(r"(```console\n\$ rocs-bt (compare .*?)\n).*?(```)", re.DOTALL)
_BODIES = (
    "robot | drive | body | clean | exact 95 % interval | collisions | falls | late | other | median time | "
    "minimum clearance"
)


def between(mark: str, made: str, page: str) -> str:
    """A page with text between `<!-- mark -->` and the next `<!-- end -->`."""
    before, head, rest = page.partition(f"<!-- {mark} -->\n")
    return f"{before}{head}{made}<!-- end -->{rest.partition('<!-- end -->')[2]}"


def table(*rows: str) -> str:
    """Markdown of a table; the first row is the head."""
    head, *others = (f"| {row} |\n" for row in rows)
    return head + "|" + "---|" * len(rows[0].split(" | ")) + "\n" + "".join(others)


def code(text: str) -> str:
    """Text of a docstring as Markdown."""
    return text.strip().replace("``", "`").replace("|", "\\|")


def actions(page: str) -> str:
    """Each shipped action with its parameters, after the head of the page."""
    return (
        page.partition("\n## ")[0] + "\n" + "\n".join(_action(name, action) for name, action in sorted(ACTIONS.items()))
    )


def _action(name: str, action: type[Action]) -> str:
    lines = [f"## {name}", "", code((inspect.getdoc(action) or "").partition("\nAttributes:\n")[0]), ""]
    rows = ["parameter | meaning | unit | range | default"]
    for key, parameter in parameters_of(action).items():
        unit, bounds = ("", "") if parameter.dimension is None else (str(parameter.dimension), str(parameter.bounds))
        meaning = re.sub(r" \[[^\]]*\](?=\.?$)", "", code(parameter.doc))
        rows.append(f"`{key}` | {meaning} | {unit} | {bounds} | {_default(parameter)}")
    return "\n".join([*lines, table(*rows) if rows[1:] else ""])


def _default(parameter) -> str:
    """A default as a content file writes it."""
    if parameter.required:
        return "needed"
    if isinstance(parameter.default, (str, bool)):
        return f"`{str(parameter.default).lower()}`"
    return "none" if parameter.default in (None, float("inf")) else f"{parameter.default:g}"


def planner(page: str) -> str:
    """The classes that a planner gets and returns."""
    return between("classes", "\n" + "\n".join(map(_class, PLANNER_CLASSES)) + "\n", page)


def _class(cls: type) -> str:
    package = "rocs_bt" if cls in (Pose2, Twist2) else "rocs_bt.plan"
    head = f"## {cls.__name__}\n\n`from {package} import {cls.__name__}`. {_first_line(cls)}\n\n"
    rows = [f"`{name}` | {code(text)}" for name, text in docs_of(cls).items()]
    for name, value in vars(cls).items():
        if name.startswith("_") or name in docs_of(cls):
            continue
        if isinstance(value, property):
            rows.append(f"`{name}` | {_first_line(value)}")
        elif inspect.isfunction(value):
            rows.append(f"`{name}({', '.join([*inspect.signature(value).parameters][1:])})` | {_first_line(value)}")
    return head + table("attribute or method | meaning", *rows)


def _first_line(value: object) -> str:
    return code((inspect.getdoc(value) or "").splitlines()[0])


def ros2(page: str) -> str:
    """The short forms `take` of each message type."""
    rows = []
    for name, message in MESSAGES.items():
        sizes = {take: f"`{size}`" if isinstance(size, str) else size for take, size in message.sizes.items()}
        forms = (f"`{take}` ({size})" for take, size in sizes.items())
        rows.append(f"`{name}` | {', '.join(forms)}")
    return between("takes", table("type | `take` (number of values)", *rows), page)


def wheeled() -> list[str]:
    """Shipped robots on wheels that have a body in the simulator and are no variants of another robot."""
    robots = [Catalog().load_robot(entry.name) for entry in Catalog().list("robot")]
    return [robot.name for robot in robots if not robot.bases and robot.motion.wheeled]


def thresholds(page: str) -> str:
    """The thresholds of avoid_collision by robot."""
    catalog, columns = Catalog(), (*_CONSTANTS, *_THRESHOLDS)
    rows = [f"robot | {' | '.join(f'`{name}`' for name in columns)}"]
    for robot in wheeled():
        ((_, rules),) = fitted_rules(catalog.find("rules", "avoid_collision"), catalog, robot)
        rows.append(" | ".join([f"`{robot}`", *(f"{rules.thresholds[n]:.3g} {rules.dimensions[n]}" for n in columns)]))
    return between("thresholds", table(*rows), page)


def bodies() -> list[str]:
    """The simulated robots that have a body of their own, by the kind of their drive."""
    robots = [Catalog().load_robot(entry.name) for entry in Catalog().list("robot")]
    own = [robot for robot in robots if not robot.bases]
    return [robot.name for robot in sorted(own, key=lambda robot: (robot.locomotion.kind, robot.name))]


def body_row(name: str, command: str) -> str:
    """The line of a robot, from its campaign."""
    script, *options = command.split()
    done = [sys.executable, ROOT / "tests/experiments" / script, *options, "--robot", name, "--json"]
    found = json.loads(subprocess.run(done, check=True, capture_output=True, text=True).stdout)["agents"]["R2"]
    robot, clean = Catalog().load_robot(name), found["clean"]
    late = sum(run["outcome"] in ("timeout", "success") for run in found["failed"])
    counts = [found["collided"]["count"], found["fell"]["count"], late]
    low, high = clean["interval"]
    return " | ".join(
        (
            f"`{name}`",
            robot.locomotion.kind,
            f"{robot.body.length:.2f} m x {robot.body.width:.2f} m",
            f"{clean['count']} of {clean['of']}",
            f"{100.0 * low:.1f} to {100.0 * high:.1f} %",
            *map(str, counts),
            str(clean["of"] - clean["count"] - sum(counts)),  # stuck or failed
            f"{found['median_time']:.1f} s",
            f"{1000.0 * found['least_clearance']:.0f} mm",
        )
    )


def campaigns(page: str) -> str:
    """EXP1 on every body, and the comparison; the comparison's episodes are kept in build/bodies."""

    def compared(found: re.Match[str]) -> str:
        arguments = [*found[2].split(), "--store", str(ROOT / "build/bodies")]
        done = CliRunner().invoke(group, arguments, catch_exceptions=False)
        printed = done.output.partition("\n\n")[2]  # after the line of episodes, which depends on the store
        return f"{found[1]}\n{printed.rstrip()}\n{found[3]}"

    def robots(found: re.Match[str]) -> str:
        return found[1] + table(_BODIES, *(body_row(name, found[2]) for name in bodies())) + "\n" + found[3]

    return _COMPARED.sub(compared, _CAMPAIGNS.sub(robots, page))


PAGES: dict[str, Callable[[str], str]] = {
    "docs/actions.md": actions,
    "docs/write-a-planner.md": planner,
    "docs/ros2.md": ros2,
    "rules/README.md": thresholds,
    "docs/bodies.md": campaigns,
}

if __name__ == "__main__":
    for path in sys.argv[1:] or [path for path in PAGES if path != "docs/bodies.md"]:
        (ROOT / path).write_text(PAGES[path]((ROOT / path).read_text("utf-8")), "utf-8")
