"""Rule files in force: what counts as a change, and what becomes of it."""

import numpy as np
import pytest

from rocs_bt.actions import ACTIONS
from rocs_bt.agent import ReloadableRules, RuleWatch
from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.errors import InputError
from rocs_bt.base.signal import Signal
from rocs_bt.base.units import LENGTH
from rocs_bt.control.locomotion_kinds import make_locomotion
from rocs_bt.event import ListSink, NullSink
from rocs_bt.expression import Environment
from rocs_bt.knowledge import Knowledge
from rocs_bt.reactive import Override, analysis

ENVIRONMENT = Environment.packed([Signal("front", 1, (LENGTH,), (0.0, 10.0))])
COMMON = 'format = "reflex/1"\n[threshold]\nnear = "0.5 m"\n'
RULES = """format = "reflex/1"
include = ["common.toml"]
[rule.Near]
when = "min(front) < near"
until = "min(front) > 1 m"
priority = 1
action = {{ name = "TurnAngle", angle = "{angle} deg" }}
"""


class Folder:
    """A rule file and one that it includes; `told` are the events."""

    def __init__(self, path, **overrides):
        self.file, self.common = path / "mine.toml", path / "common.toml"
        self.common.write_text(COMMON)
        self.file.write_text(RULES.format(angle=60))
        knowledge = Knowledge("R1", SimulatedClock(0.05), NullSink())
        knowledge.robot.locomotion = make_locomotion(
            "differential", wheel_separation=0.3, max_wheel_speed=1.0, max_wheel_acceleration=1.0
        )
        own = {k: Override(v) for k, v in overrides.items()}
        self.rules = ReloadableRules(self.file, ENVIRONMENT, ACTIONS, own, knowledge)
        self.sink = ListSink()

    def look(self):
        before = len(self.sink.events)
        RuleWatch([("R1", self.rules)], SimulatedClock(0.05), self.sink, watching=True).check()
        return [(e.accepted, e.detail) for e in self.sink.events[before:]]

    def latched(self, front, t):
        reflexes = self.rules.model.react(np.array([front]), t)
        return [r.parameters for r in reflexes if r.latched]


def test_nothing_is_done_while_nothing_changes(tmp_path):
    folder = Folder(tmp_path)
    before = folder.rules.model.rules
    assert folder.look() == []
    assert folder.rules.model.rules is before


def test_an_action_that_does_not_fit_the_robot_is_refused_and_the_old_rules_stay(tmp_path):
    folder = Folder(tmp_path)
    before = folder.rules.model.rules
    speeds = ['["0.1 m/s"]', '["0.1 m/s", "0.1 m/s"]']
    one, two = (
        RULES.format(angle=60).replace('"TurnAngle", angle = "60 deg"', f'"SetWheelSpeed", speeds = {s}')
        for s in speeds
    )
    folder.file.write_text(one)
    ((accepted, detail),) = folder.look()
    assert not accepted
    assert f"{folder.file}:7:" in detail
    assert "the drive takes 2 wheel speeds (left, right), found 1" in detail
    assert folder.rules.model.rules is before
    folder.file.write_text(two)
    assert folder.look() == [(True, "active rules (1): mine/Near")]


def test_a_latched_rule_goes_on_with_its_new_action(tmp_path):
    folder = Folder(tmp_path)
    assert folder.latched(0.4, 0.0)[0]["angle"] == pytest.approx(np.radians(60))
    folder.file.write_text(RULES.format(angle=90.5))
    assert folder.look() == [(True, "active rules (1): mine/Near")]
    assert folder.latched(0.8, 0.1)[0]["angle"] == pytest.approx(np.radians(90.5))  # only `until` would let it go
    assert folder.look() == []


def test_an_included_file_counts_and_a_robots_thresholds_stay(tmp_path):
    folder = Folder(tmp_path)
    folder.common.write_text(COMMON.replace("0.5 m", "0.25 m"))
    assert [accepted for accepted, _ in folder.look()] == [True]
    assert folder.latched(0.4, 0.0) == []
    own = Folder(tmp_path, near="0.45 m")
    own.common.write_text(COMMON.replace("0.5 m", "0.125 m"))
    own.look()
    assert len(own.latched(0.4, 0.0)) == 1


def test_what_is_wrong_is_said_once_and_the_old_rules_stay(tmp_path):
    folder = Folder(tmp_path)
    folder.common.write_text(COMMON.replace("0.5 m", "0.5 s"))
    ((accepted, detail),) = folder.look()
    assert not accepted
    assert "the old rules stay active: " in detail
    assert "mine.toml:4:9" in detail
    assert folder.look() == []
    assert len(folder.latched(0.4, 0.0)) == 1
    with pytest.raises(InputError, match="needs one unit"):
        folder.rules.reload()
    folder.common.unlink()
    assert [accepted for accepted, _ in folder.look()] == [False]
    folder.common.write_text(COMMON)
    assert [accepted for accepted, _ in folder.look()] == [True]


def test_a_broken_file_that_is_new_among_the_included_is_looked_at(tmp_path):
    folder = Folder(tmp_path)
    more = folder.common.with_name("more.toml")
    more.write_text(COMMON.replace("0.5 m", "0.5 s"))
    folder.file.write_text(folder.file.read_text().replace('"common.toml"', '"more.toml"'))
    assert [accepted for accepted, _ in folder.look()] == [False]
    more.write_text(COMMON.replace("0.5 m", "0.125 m"))
    assert [accepted for accepted, _ in folder.look()] == [True]
    assert folder.latched(0.4, 0.0) == []


def test_what_changes_while_it_is_read_is_another_change(tmp_path, monkeypatch):
    folder, first, second = Folder(tmp_path), RULES.format(angle=90.5), RULES.format(angle=120.25)
    checked = analysis.examine_rules

    def slow(*args):
        found = checked(*args)
        folder.file.write_text(second)
        return found

    folder.file.write_text(first)
    monkeypatch.setattr(analysis, "examine_rules", slow)
    assert [accepted for accepted, _ in folder.look()] == [True]
    assert folder.rules.changed()
    folder.file.write_text("broken")
    folder.look()
    assert folder.rules.changed()


def test_a_watching_thread_that_fails_says_so_where_it_is_waited_for(tmp_path, monkeypatch):
    folder = Folder(tmp_path)

    def broken(*args):
        raise RuntimeError("a defect")

    monkeypatch.setattr(ReloadableRules, "changed", broken)
    monkeypatch.setattr("rocs_bt.agent.reloadable_rules.POLL", 0.001)
    watch = RuleWatch([("R1", folder.rules)], SimulatedClock(0.05), folder.sink, watching=True)
    with pytest.raises(RuntimeError, match="a defect"), watch:
        watch._thread.join(5.0)
