"""Scripts of actors in a project: the one of docs/families.md, and faults of others."""

import math
import re
from pathlib import Path

import pytest

from rocs_bt import Catalog, run
from rocs_bt.base.errors import InputError, RecordingError
from rocs_bt.check import check_content
from rocs_bt.event import BodyMoved, ListSink
from rocs_bt.record import Recording
from rocs_bt.running.replay import replay

from ..changes import edit

PAGE = (Path(__file__).parents[2] / "docs/families.md").read_text("utf-8")
FILES = dict(re.findall(r"Save as `(.+?)`:\n\n```\w+\n(.*?)```", PAGE, re.DOTALL))
SCRIPT, SCENARIO = "scenarios/people.py", "scenarios/round.toml"
TURN = """

from rocs_bt import RadiansPerSecond, Twist2
from rocs_bt.simulation import ScriptedRobot


class Turn(ScriptedRobot):
    \"\"\"Turns on the spot.\"\"\"

    rate: RadiansPerSecond

    def twist(self, t, pose):
        return Twist2(0.0, self.rate)
"""
ROBOT = """
[[actor]]
name = "P"
robot = "pioneer_p3dx"
script = "people.py:Turn"
rate = "0.5 rad/s"
x = "2 m"
y = "1.2 m"
yaw = "0 deg"
"""


@pytest.fixture
def project(tmp_path: Path) -> Path:
    (tmp_path / "scenarios").mkdir()
    for name, text in FILES.items():
        (tmp_path / name).write_text(text, "utf-8")
    return tmp_path


def moved(project: Path, name: str, duration: float, **given) -> list[BodyMoved]:
    sink = ListSink()
    run("round", Catalog(project), duration=duration, sinks=[sink], **given)
    return [event for event in sink.events if isinstance(event, BodyMoved) and event.body == name]


def test_the_person_of_the_page_walks_in_a_circle(project: Path) -> None:
    found = moved(project, "person_2", 3.0)
    start, last = found[0], found[-1]
    for event in found:
        assert math.dist((event.x, event.y), (start.x, start.y + 1.0)) == pytest.approx(1.0, abs=0.02)
    assert math.dist((last.x, last.y), (start.x, start.y)) > 1.0


def test_a_script_drives_a_robot(project: Path) -> None:
    (project / SCRIPT).write_text(FILES[SCRIPT] + TURN, "utf-8")
    (project / SCENARIO).write_text(FILES[SCENARIO] + ROBOT, "utf-8")
    first, *_, last = moved(project, "P", 2.0)
    assert last.yaw - first.yaw == pytest.approx(0.5 * (last.t - first.t), rel=0.1)


@pytest.mark.parametrize(
    ("file", "old", "new", "told"),
    [
        (SCENARIO, "people.py:Circle", "persons.py:Circle", "round.toml:7:1: there is no file 'persons.py' beside"),
        (SCENARIO, "people.py:Circle", "people.py:Cycle", "round.toml:7:1: 'people.py' has no class 'Cycle'. Did you"),
        (SCENARIO, "people.py:Circle", "circle", "round.toml:7: no object script is named 'circle'."),
        (SCENARIO, 'speed = "0.6 m/s"', 'speed = "0.6 m"', "round.toml:8:1: speed must be in m/s, found '0.6 m'"),
        (SCENARIO, 'speed = "0.6 m/s"', 'pace = "1 m/s"', "no parameter is named 'pace'"),
        (SCENARIO, 'speed = "0.6 m/s"', "", "round.toml:5:1: Circle 'person_2' needs 'speed'."),
        (SCRIPT, "Circle(ScriptedObject)", "Circle", "'Circle' is no script of an object. Write: class Circle(Scr"),
        (
            SCRIPT,
            "radius: PositiveMetres = 1.0",
            "radius: PositiveMetres = 1.0\n    start: PositiveMetres = 1.0",
            "'start' of 'Circle' is no name of a key. Give the key another name",
        ),
        (
            SCRIPT,
            "def velocity",
            "def __init__(self):\n        pass\n\n    def velocity",
            "'Circle' has an __init__. Name it",
        ),
        (SCRIPT, "def velocity", "def speed_at", "the script 'Circle' has no method velocity"),
        (SCRIPT, "    def velocity", "    def begin(self):\n        1 / 0\n\n    def velocity", "people.py:14: Circle"),
        (SCRIPT, "import cos, sin", "import cosine", "people.py:1: "),
    ],
)
def test_a_faulty_script_is_reported_at_its_line_by_the_check(project, file, old, new, told) -> None:
    edit(project / file, old, new)
    lines = [str(fault) for fault in check_content([project / SCENARIO]).faults]
    assert any(told in line for line in lines), lines


def test_an_exception_of_a_script_ends_the_run_at_its_line(project: Path) -> None:
    edit(project / SCRIPT, "way = ", "way = 1 / (t < 0.5) * ")
    with pytest.raises(InputError, match=r"people\.py:14: Circle of this file raised ZeroDivisionError"):
        run("round", Catalog(project), duration=2.0)


def test_no_code_of_it_runs_if_that_is_refused(project: Path) -> None:
    with pytest.raises(InputError, match=r"people\.py: this Python content may not run"):
        run("round", Catalog(project, code=False), duration=1.0)


def test_a_recording_replays_until_the_script_changes(project: Path) -> None:
    out = project / "runs/round"
    run("round", Catalog(project), duration=1.0, out=out)
    recording = Recording.open(out)
    assert replay(recording, Catalog(project)) is None
    edit(project / SCRIPT, "1.0 - cos", "1.00 - cos")
    with pytest.raises(RecordingError, match="has changed since"):
        replay(recording, Catalog(project))
