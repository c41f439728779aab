"""Driving robots that are not simulated: a user's own drivers, wall time, and what breaks on the way."""

from __future__ import annotations

import json
import threading
from collections.abc import Callable
from pathlib import Path

import pytest

from rocs_bt import drive, run
from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.errors import DeviceError, Fault, InputError
from rocs_bt.catalog import Catalog
from rocs_bt.check import check_content
from rocs_bt.cli.main import call
from rocs_bt.event import (
    AgentStopped,
    Event,
    ListSink,
    MotionHeld,
    MotionReleased,
    RuleChanged,
    RulesReplaced,
    RunControlled,
    SensorFailed,
    Stuck,
)
from rocs_bt.running import Host, RunCommand, RunResult, preflight
from rocs_bt.simulation import progress

from ..pages import data_of

pytestmark = pytest.mark.usefixtures("awake")

# A robot that lives in this process and in one object: it drives as it is told, exactly.
DRIVERS = """
import math
import threading
import time
from rocs_bt import Actuator, Reading, Sensor
from rocs_bt.base.errors import DeviceError

PLAN = {plan!r}
SEEN = []


class Body:
    def __init__(self, clock):
        self.clock, self.x, self.speed, self.at, self.closed = clock, -0.6, 0.0, clock.now(), False
        self.frozen, self.open, self.stops = None, [], []
        SEEN.append(self)

    def now(self):
        t = self.clock.now()
        speed = 0.0 if PLAN == "blocked" and t < 2.0 else self.speed
        self.x, self.at = self.x + speed * (t - self.at), t
        return t

    def close(self):
        self.closed = True


class Part(Sensor):
    def __init__(self, name, host):
        super().__init__(name)
        self.body, self.wobble = host.share("body", lambda: Body(host.clock)), 0
        self.body.open.append(name)

    def close(self):
        self.body.open.remove(self.name)

    def read(self):
        t = self.body.now()
        self.wobble += 1
        if PLAN == "silent" and t > 1.0:
            t = 1.0
        said = {{
            "sonar": [math.inf] * 15 + [0.9 + 1e-6 * self.wobble],
            "position": [self.body.x, 1e-9 * self.wobble, 0.0],
            "orientation": [0.0],
            "encoders": [self.body.speed] * 2,
        }}
        return Reading(t, said[self.name])


class Wheels(Actuator):
    def __init__(self, name, host):
        super().__init__(name, 2)
        self.body, self.count = host.share("body", lambda: Body(host.clock)), 0
        if PLAN == "unreachable":
            raise DeviceError("nobody answers")
        self.body.open.append(name)

    def close(self):
        self.body.open.remove(self.name)

    def command(self, values):
        self.body.now()
        self.count += 1
        if PLAN == "refuses" and self.count > 5:
            raise DeviceError("the fuse blew")
        self.body.speed = 0.5 * (values[0] + values[1])

    def neutral(self):
        self.body.now()
        self.body.stops.append(time.monotonic())
        self.body.speed = 0.0
"""


@pytest.fixture
def real(tmp_path: Path) -> Callable[[str], Catalog]:
    """A project with a scenario `real`, whose robot behaves as a plan says."""

    def make(plan: str = "fine") -> Catalog:
        folder = tmp_path / "robots" / "own"
        folder.mkdir(parents=True)
        (folder / "own.py").write_text(DRIVERS.format(plan=plan))
        names = ("sonar", "position", "orientation", "encoders")
        tables = [f'[[sensor]]\nname = "{name}"\ndriver = "own.py:Part"\n' for name in names]
        tables.append('[[actuator]]\nname = "wheels"\ndriver = "own.py:Wheels"\n')
        head = 'format = "robot/3"\nbase = "pioneer_p3dx"\n'
        (folder / "robot.toml").write_text(head + "".join(tables))
        (tmp_path / "scenarios").mkdir()
        (tmp_path / "scenarios" / "real.toml").write_text(
            'format = "scenario/2"\nbase = "exp1"\n[[agent]]\nname = "R2"\nrobot = "own"\n'
        )
        return Catalog(tmp_path)

    return make


def errors_of(file: Path) -> list[Fault]:
    return [fault for fault in check_content([file]).faults if not fault.warning]


def body(catalog: Catalog) -> object:
    robot = catalog.load_robot("own")
    return catalog.load_class(robot.beside("own.py"), "Part").read.__globals__["SEEN"][-1]


def reason(found: RunResult) -> str:
    return found.summary.agents["R2"].reason


def test_the_mission_drives_it_to_the_goal_and_everything_is_closed(real: Callable[[str], Catalog]) -> None:
    catalog = real("fine")
    assert drive("real", catalog, duration=10.0).outcomes == {"R2": "success"}
    robot = body(catalog)
    assert abs(robot.x) < 0.1
    assert robot.speed == 0.0
    assert robot.open == []
    assert robot.closed


def test_a_device_that_cannot_be_reached_leaves_none_open(real: Callable[[str], Catalog]) -> None:
    catalog = real("unreachable")
    with pytest.raises(DeviceError, match="nobody answers"):
        drive("real", catalog)
    assert body(catalog).open == []
    assert body(catalog).closed


def test_when_time_is_up_the_wheels_stand(real: Callable[[str], Catalog]) -> None:
    catalog, sink = real("fine"), ListSink()
    assert drive("real", catalog, duration=0.7, sinks=[sink]).outcomes == {"R2": "timeout"}
    (stopped,) = (e for e in sink.events if isinstance(e, AgentStopped))
    assert 0.7 + preflight.OBSERVED <= stopped.t < 2.0  # by the run's clock
    assert body(catalog).speed == 0.0


def test_the_end_of_a_run_is_neutral_three_times_with_pauses(real: Callable[[str], Catalog]) -> None:
    catalog = real("fine")
    drive("real", catalog, duration=0.2)
    first, second, third = body(catalog).stops[-3:]
    assert min(second - first, third - second) >= 0.02


def test_a_robot_that_falls_silent_is_stopped_by_a_reflex(real: Callable[[str], Catalog]) -> None:
    catalog, sink = real("silent"), ListSink()
    assert drive("real", catalog, duration=1.5, sinks=[sink]).outcomes == {"R2": "timeout"}
    assert {e.sensor for e in sink.events if isinstance(e, SensorFailed)} >= {"sonar", "position"}
    assert [e.rule for e in sink.events if isinstance(e, RuleChanged) and e.phase == "fired"]
    assert body(catalog).speed == 0.0
    assert body(catalog).x < -0.2


def test_no_progress_is_an_event_and_does_not_end_the_run(
    real: Callable[[str], Catalog], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Until t = 2 s something holds the robot, with a patience of 1 s instead of 15."""
    monkeypatch.setattr(progress, "PATIENCE", 1.0)
    sink = ListSink()
    found = drive("real", real("blocked"), duration=10.0, sinks=[sink])
    (stuck,) = (e for e in sink.events if isinstance(e, Stuck))
    assert stuck.agent == "R2"
    assert 1.0 <= stuck.t < 2.0
    assert stuck.reason.startswith("it moved less than 0.05 m in 1 s near x = -0.60 m, y = 0.00 m")
    assert found.outcomes == {"R2": "success"}
    assert found.summary.agents["R2"].faults == (f"{stuck.t:.2f} s: {stuck.reason}",)


def test_no_progress_until_the_end_of_the_run_is_its_outcome(
    real: Callable[[str], Catalog], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(progress, "PATIENCE", 0.5)
    found = drive("real", real("blocked"), duration=1.5)
    assert found.outcomes == {"R2": "stuck"}
    assert reason(found).startswith("it moved less than 0.05 m in 0.5 s")


def test_files_and_summary_of_a_run_on_hardware(
    real: Callable[[str], Catalog], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    found = drive("real", real("fine"), duration=10.0, out=tmp_path / "out")
    summary = json.loads((tmp_path / "out/summary.json").read_text())
    assert summary == json.loads(found.summary.to_json())
    agent = summary["agents"]["R2"]
    assert agent["outcome"] == "success"
    assert agent["time_to_goal"] > 1.0
    assert agent["path_length"] == pytest.approx(0.6, abs=0.15)
    unknown = ("collisions", "struck", "contacts", "min_clearance", "goals_reached", "localisation")
    assert [agent[key] for key in unknown] == [None] * len(unknown)
    assert (summary["simulated"], summary["trajectory_hash"]) == (False, None)
    page = data_of(tmp_path / "out/report.html")
    assert page["results"]["R2"]["outcome"] == "success"
    assert "time to goal" in dict(page["results"]["R2"]["numbers"])
    assert call(["report", str(tmp_path / "out")]) == 0
    assert json.loads((tmp_path / "out/summary.json").read_text()) == summary
    told = capsys.readouterr().out
    assert told.startswith("R2 success in ")
    assert "collision" not in told
    assert " s in all" in told


def test_a_device_that_refuses_stops_the_robot_and_is_told(real: Callable[[str], Catalog]) -> None:
    catalog = real("refuses")
    assert "the fuse blew" in reason(drive("real", catalog, duration=5.0))
    assert body(catalog).speed == 0.0


def test_a_mind_that_is_late_loses_the_wheels(real: Callable[[str], Catalog], monkeypatch: pytest.MonkeyPatch) -> None:
    from rocs_bt.execute import Execute

    catalog, sink, before = real("fine"), ListSink(), Execute.run

    def hang(self: Execute, t: float) -> None:
        if t > 0.6:
            clock = body(catalog).clock
            clock.wait_until(clock.now() + 0.8, threading.Event())
        before(self, t)

    monkeypatch.setattr(Execute, "run", hang)
    drive("real", catalog, duration=3.0, sinks=[sink])
    assert [e.reason for e in sink.events if isinstance(e, MotionHeld) and "execute" in e.reason]
    assert body(catalog).speed == 0.0


def test_a_simulations_driver_and_a_class_of_another_kind_are_refused(real: Callable[[str], Catalog]) -> None:
    with pytest.raises(InputError, match="the driver 'range_cone' of 'sonar' is for simulation only"):
        drive("exp1", Catalog(), duration=1.0)
    catalog = real("fine")
    file = catalog.load_robot("own").file
    file.write_text(file.read_text().replace("own.py:Wheels", "own.py:Part"))
    with pytest.raises(InputError, match=r"'own.py:Part' of 'wheels' does not extend rocs_bt.Actuator") as caught:
        drive("real", catalog, duration=1.0)
    assert caught.value.faults[0].file == file


TAKES_TWO = "def __init__(self, name, host):\n        super().__init__(name, 2)"


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("class Part", "@dataclass\nclass Part", "'Part' is a dataclass. Remove the decorator, and write __init__("),
        ("def __init__", "def begin", "the constructor of 'Part' does not take name and host. Write __init__(self,"),
        (TAKES_TWO, TAKES_TWO.replace(", host", ""), "the constructor of 'Wheels' does not take name and host."),
        (TAKES_TWO, TAKES_TWO.replace("host", "host, port"), "the constructor of 'Wheels' needs port. Declare it by"),
        (TAKES_TWO, TAKES_TWO.replace("host", "*, host"), "needs host. Take host by position: write __init__(self,"),
    ],
)
def test_a_driver_that_cannot_be_constructed_is_refused_with_advice(real, old: str, new: str, message: str) -> None:
    file = real().load_robot("own").beside("own.py")
    before, part, after = file.read_text().partition("class Part")
    file.write_text("from dataclasses import dataclass\n" + before + (part + after).replace(old, new, 1))
    faults = errors_of(file.with_name("robot.toml"))
    assert {message in str(fault) and fault.file == file and fault.line > 20 for fault in faults} == {True}


def test_a_driver_may_have_slots_for_its_keys(real) -> None:
    robot = real().load_robot("own")
    file = robot.beside("own.py")
    text = file.read_text()
    slots = text.replace("class Part(Sensor):", "class Part(Sensor):\n    __slots__ = ('port',)\n    port: str\n")
    file.write_text(slots.replace("super().__init__(name)", "super().__init__(name + self.port)"))
    assert "needs port" in str(errors_of(robot.file)[0])
    robot.file.write_text(robot.file.read_text().replace('"own.py:Part"\n', '"own.py:Part"\nport = "A"\n'))
    assert not errors_of(robot.file)


def test_a_real_robot_passes_the_check_and_cannot_be_simulated(real: Callable[[str], Catalog]) -> None:
    catalog = real("fine")
    assert catalog.project is not None
    found = check_content([catalog.project])
    assert [f.message for f in found.faults] == [
        "nothing sends neutral to 'wheels' if this program hangs, is stopped or killed."
    ]
    with pytest.raises(InputError, match="the driver 'Part' of 'sonar' is for real robots"):
        run("real", catalog, duration=1.0)


def test_what_drivers_share_is_made_once_and_closed_once() -> None:
    host, made = Host(SimulatedClock(0.1)), []

    class Link:
        def __init__(self) -> None:
            self.closed = 0
            made.append(self)

        def close(self) -> None:
            self.closed += 1

    assert host.share("a", Link) is host.share("a", Link) is not host.share("b", Link)
    host.close()
    assert [link.closed for link in made] == [1, 1]


def test_rules_that_are_broken_meanwhile_are_told(real: Callable[[str], Catalog], tmp_path: Path) -> None:
    catalog = real("fine")
    rules = tmp_path / "rules" / "avoid_collision.toml"
    rules.parent.mkdir()
    rules.write_text(Catalog().find("rules", "avoid_collision").path.read_text("utf-8"), "utf-8")

    class Spoiler(ListSink):
        """Breaks the rules once time passes."""

        broken = False

        def emit(self, event: Event) -> None:
            super().emit(event)
            if event.t > 0.0 and not self.broken:
                self.broken = True
                rules.write_text("no rules at all")

    sink = Spoiler()
    drive("real", catalog, duration=1.2, sinks=[sink], watch_rules=True)
    (told,) = [e for e in sink.events if isinstance(e, RulesReplaced)]
    assert (told.agent, told.rules, told.accepted) == ("R2", "avoid_collision", False)
    assert "the old rules stay active: " in told.detail


@pytest.mark.parametrize("full", [False, True])
def test_a_pause_lasts_until_the_person_at_the_robot_says_go(real: Callable[[str], Catalog], full: bool) -> None:
    commands = {4: ["pause"], 6: ["continue", "reload"]}

    class Person:
        asked = 0

        def take(self) -> list[RunCommand]:
            self.asked += 1
            return [RunCommand(kind=kind, rules="avoid_collision") for kind in commands.get(self.asked, [])]

    person, sink = Person(), ListSink()
    options = {"duration": 1.2, "sinks": [sink], "control": person, "full_control": full}
    drive("real", real("fine"), go=lambda: person.asked == 12, **options)
    told = [(e.command, bool(e.refusal)) for e in sink.events if isinstance(e, RunControlled)]
    assert told == [("pause", False), ("continue", True), ("reload", not full)]
    held = next(e for e in sink.events if isinstance(e, MotionHeld))
    released = next(e for e in sink.events if isinstance(e, MotionReleased))
    assert held.reason == "paused by the page, waiting for go"
    assert released.by == "the terminal"
    assert held.t + 0.3 < released.t
