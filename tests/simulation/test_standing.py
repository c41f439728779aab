"""A robot that stands its ground while another one drives on into it, on tyres that slip."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from rocs_bt import AgentResult, run
from rocs_bt.actions import Flinch
from rocs_bt.base.geometry import Pose2
from rocs_bt.catalog import Catalog
from rocs_bt.event import BodyMoved
from rocs_bt.record.file.recording import Recording

WALL = 2.475  # [m] the east wall's face, in scenarios/worlds/arena.xml
LIMP = "0 m/s"  # lets itself be pushed
SHIPPED = f"{Flinch.resist} m/s"
STERN = 0.272  # [m] how far a Pioneer reaches behind its axle


MISSION = """<root BTCPP_format="4" main_tree_to_execute="{name}"><BehaviorTree ID="{name}">
{leaf}
</BehaviorTree></root>"""

ROBOT = """format = "robot/3"
base = "pioneer_p3dx"
doc = "A Pioneer that only stands when something is near, ahead and behind."
"""

RULES = Catalog().find("rules", "avoid_collision").path.read_text(encoding="utf-8")
ONLY = 'creep = "0 m/s"\nclearance = "1 m"'  # stands where it would creep or turn out

SCENARIO = """format = "scenario/2"
world = "{world}"
duration = "8 s"
end_on_collision = false
[[agent]]
name = "R1"
robot = "pioneer_p3dx"
mission = "push"
x = "{r1} m"
y = "{aside} m"
[[agent]]
name = "R2"
robot = "stander"
mission = "{mission}"
rules = {rules}
x = "{r2} m"
y = "0 m"
yaw = "{yaw} deg"
"""


def play(project: Path, resist: str, **scenario: Any) -> AgentResult:
    """R1 drives at 0.2 m/s into R2, which stands; R2's part of the summary."""
    leaves = {
        "push": '<SetWheelSpeed speeds="0.2 m/s; 0.2 m/s" duration="60 s"/>',
        "stand": f'<Flinch speed="0 m/s" resist="{resist}"/>',
        "wait": '<Stop below="0 m/s" patience="60 s"/>',
    }
    files = {
        **{f"planners/missions/{name}.xml": MISSION.format(name=name, leaf=leaf) for name, leaf in leaves.items()},
        "robots/stander/robot.toml": ROBOT,
        "rules/avoid_collision.toml": RULES.replace("get_out = true", f'get_out = true\nresist = "{resist}"\n{ONLY}'),
        "scenarios/push.toml": SCENARIO.format(**scenario),
    }
    for file, text in files.items():
        (project / file).parent.mkdir(parents=True, exist_ok=True)
        (project / file).write_text(text, encoding="utf-8")
    return run("push", Catalog(project), out=project / "run", report=False).summary.agents["R2"]


@pytest.mark.parametrize(
    ("yaw", "aside", "slides"), [(180.0, 0.0, 0.5), (180.0, 0.1, 0.5), (162.0, 0.0, 0.5), (0.0, 0.0, 0.2)]
)
def test_who_is_pushed_ahead_or_back_gives_little_way(tmp_path: Path, yaw: float, aside: float, slides: float) -> None:
    scene = {"world": "plane", "r1": -0.6, "r2": 0.0, "yaw": yaw, "aside": aside, "mission": "stand", "rules": []}

    def pushed(resist: str) -> float:
        """How far it was ever from where it stood [m]."""
        assert play(tmp_path, resist, **scene).struck == 1
        moves = [e for e in Recording.open(tmp_path / "run").events() if isinstance(e, BodyMoved) and e.body == "R2"]
        return max(Pose2(0.0, 0.0).distance(Pose2(e.x, e.y)) for e in moves)

    assert pushed(LIMP) > slides
    assert pushed(SHIPPED) < 0.2


@pytest.mark.parametrize("aside", [0.0, 0.08])
@pytest.mark.parametrize("gap", [0.1, 0.18, 0.22])
def test_nobody_pushes_it_into_the_wall_behind_it(tmp_path: Path, gap: float, aside: float) -> None:
    r2 = WALL - STERN - gap
    scene = {"world": "arena", "r1": r2 - 0.5, "r2": r2, "yaw": 180.0, "aside": aside}
    scene |= {"mission": "wait", "rules": '["avoid_collision"]'}

    def touched(resist: str) -> dict[str, Any]:
        return {kind: sorted(counts) for kind, counts in play(tmp_path, resist, **scene).contacts.items()}

    assert any("wall_east" in others for others in touched(LIMP).values())
    assert touched(SHIPPED) == {"struck": ["R1"]}
