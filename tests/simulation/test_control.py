"""Commands of a person to a run, between its control periods: pause, step, continue, swap, reload."""

from __future__ import annotations

import shutil

import pytest

from rocs_bt import replay, run
from rocs_bt.catalog import Catalog
from rocs_bt.event import BodyMoved, ListSink, RulesReplaced, RunControlled, SubtreeSwapped
from rocs_bt.record import Recording
from rocs_bt.record.explanation.why_not import why_not
from rocs_bt.record.fold.tracks import Tracks
from rocs_bt.running import RunCommand

FIRST = '<root BTCPP_format="4"><BehaviorTree ID="own"><Sleep name="nap" msec="9000"/></BehaviorTree></root>'
SECOND = '<root BTCPP_format="4"><BehaviorTree ID="own"><Sleep name="wink" msec="100"/></BehaviorTree></root>'

SCENARIO = """
format = "scenario/2"
world = "arena"
duration = "9 s"
[[agent]]
name = "R2"
robot = "pioneer_p3dx"
mission = "own"
rules = ["avoid_collision"]
x = "-1.5 m"
y = "0 m"
"""


class Person:
    """Control with commands by the number of the question; while a run is paused it is asked again and again."""

    def __init__(self, commands):
        self.commands, self.asked = commands, 0

    def take(self):
        self.asked += 1
        return [RunCommand(by="Ann", **c) for c in self.commands.get(self.asked, ())]


def kinds(*names):
    return [{"kind": name} for name in names]


@pytest.fixture
def project(tmp_path):
    for folder in ("planners/missions", "rules", "scenarios"):
        (tmp_path / folder).mkdir(parents=True)
    (tmp_path / "planners/missions/own.xml").write_text(FIRST)
    (tmp_path / "planners/missions/other.xml").write_text(SECOND)
    shutil.copy(Catalog().find("rules", "avoid_collision").path, tmp_path / "rules/avoid_collision.toml")
    (tmp_path / "scenarios/own.toml").write_text(SCENARIO)
    return tmp_path


def play(project, commands, **options):
    sink, person = ListSink(), Person(commands)
    options = {"duration": 1.0, "sinks": [sink], "control": person, **options}
    found = run("own", Catalog(project), report=False, **options)
    return found, sink.events, person


def told(events):
    return [(round(e.t, 2), e.command, bool(e.refusal)) for e in events if isinstance(e, RunControlled)]


def test_pauses_and_steps_change_nothing_but_the_record(project):
    plain, before, _ = play(project, {})
    commands = {
        3: kinds("pause"),
        6: kinds("step"),
        8: kinds("step"),
        9: kinds("continue", "step"),
        12: kinds("continue"),
    }
    paused, after, person = play(project, commands, out=project / "run")
    assert paused.summary.trajectory_hash == plain.summary.trajectory_hash
    assert [e for e in after if isinstance(e, BodyMoved)] == [e for e in before if isinstance(e, BodyMoved)]
    assert told(after) == [
        (0.1, "pause", False),
        (0.1, "step", False),
        (0.15, "step", False),
        (0.2, "continue", False),
        (0.2, "step", False),
        (0.25, "continue", False),
    ]
    assert person.asked > 21  # the run waited for it
    assert replay(Recording.open(paused.recording), Catalog(project)) is None
    assert "Ann: pause" in [e.sentence for e in after]


def test_a_signal_ends_a_paused_run(project):
    from rocs_bt.running import StopSignals

    class Signalled(StopSignals):
        @property
        def reason(self):
            return "SIGTERM ended the run" if person.asked > 4 else ""

    person, signals = Person({2: kinds("pause")}), Signalled()
    found = run("own", Catalog(project), seed=1, duration=9.0, report=False, control=person, signals=signals)
    assert found.outcomes == {"R2": "interrupted"}


def test_a_swap_is_made_at_once_and_replays(project):
    swap = {"kind": "swap", "node": "nap", "mission": "other"}
    wrong = [{**swap, "node": "dream"}, {**swap, "mission": "none"}, {**swap, "agent": "R9"}]
    found, events, _ = play(project, {5: [swap], 3: wrong}, out=project / "run")
    assert told(events) == [(0.1, "swap", True)] * 3 + [(0.2, "swap", False)]
    (made,) = [e for e in events if isinstance(e, RunControlled) and not e.refusal]
    assert (made.target, made.source, made.sentence) == ("R2:nap", "other", "Ann: swap 'R2:nap' by other")
    assert [(round(e.t, 2), e.node) for e in events if isinstance(e, SubtreeSwapped)] == [(0.2, "nap")]
    assert found.outcomes == {"R2": "success"}
    recording = Recording.open(found.recording)
    assert replay(recording, Catalog(project)) is None
    (project / "planners/missions/other.xml").write_text(SECOND.replace("100", "200"))
    with pytest.raises(Exception, match=r"the mission 'other' has changed since the swap at 0\.2 s"):
        replay(recording, Catalog(project))


def test_a_rule_file_is_reloaded_when_a_person_says_so(project):
    rules = project / "rules/avoid_collision.toml"

    class Editor(Person):
        def take(self):
            if self.asked == 3:
                rules.write_text("nothing")
            return super().take()

    commands = {
        2: [{"kind": "reload", "rules": "avoid_collision"}],
        6: [{"kind": "reload", "rules": "avoid_collision"}],
    }
    commands[8] = [{"kind": "reload", "rules": "none"}]
    sink = ListSink()
    run("own", Catalog(project), duration=0.6, report=False, sinks=[sink], control=Editor(commands))
    assert told(sink.events) == [(0.05, "reload", False), (0.25, "reload", False), (0.35, "reload", True)]
    assert [(round(e.t, 2), e.accepted) for e in sink.events if isinstance(e, RulesReplaced)] == [
        (0.05, True),
        (0.25, False),
    ]


def test_in_threaded_mode_a_pause_holds_the_robots_in_neutral(project):
    from rocs_bt.event import MotionHeld, MotionReleased

    commands = {3: kinds("pause"), 8: kinds("step", "continue")}
    _, events, _ = play(project, commands, mode="threaded")
    assert [c[1:] for c in told(events)] == [("pause", False), ("step", True), ("continue", False)]
    (held,) = [e for e in events if isinstance(e, MotionHeld)]
    (released,) = [e for e in events if isinstance(e, MotionReleased)]
    assert held.reason == "paused by Ann"
    assert held.t < released.t


@pytest.mark.parametrize("restored", [False, True])
def test_a_run_with_reloaded_rules_replays(project, restored):
    rules = project / "rules/avoid_collision.toml"
    old = rules.read_text()

    class Editor(Person):
        def take(self):
            if self.asked == 3:
                rules.write_text(old.replace("[rule.Flinch", "[rule.Backwards"))
            return super().take()

    editor = Editor({6: [{"kind": "reload", "rules": "avoid_collision"}]})
    found = run("own", Catalog(project), duration=0.6, report=False, control=editor, out=project / "run")
    recording = Recording.open(found.recording)
    (made,) = [e for e in recording.events() if isinstance(e, RulesReplaced)]
    assert (made.before, "Backwards" in made.detail) == ({"avoid_collision.toml": old}, True)
    if restored:
        rules.write_text(old)
    assert replay(recording, Catalog(project)) is None


def test_after_a_reload_the_new_guard_explains(project):
    """Its comparisons and thresholds; the old one explains what was before, and a rule that is gone has none."""
    file = project / "rules/avoid_collision.toml"
    text = file.read_text()
    changed = text.replace('flinch_near = "0.20 m"', 'flinch_near = "0.19 m"').replace(
        'when = "around < min(flinch_near, to_goal)"', 'when = "around < flinch_near and speed < 7 m/s"'
    )
    head, _, rest = changed.partition("[rule.AvoidCollision]")

    class Editor(Person):
        def take(self):
            if self.asked == 9:
                file.write_text(head + rest[rest.index("[rule.AvoidCourse]") :])
            return super().take()

    editor = Editor({11: [{"kind": "reload", "rules": "avoid_collision"}]})
    run("own", Catalog(project), duration=1.0, control=editor, report=False, out=project / "run")
    tracks = Tracks.of_recording(Recording.open(project / "run"))
    (event,) = (e for e in tracks.events if isinstance(e, RulesReplaced))
    assert event.accepted, event.detail
    flinch, avoid = "avoid_collision/Flinch", "avoid_collision/AvoidCollision"
    before, after = event.t - 0.05, event.t + 0.1
    found = [tracks.guard("R2", flinch, t).thresholds["flinch_near"] for t in (before, event.t, after)]
    assert found == ["0.2 m", "0.19 m", "0.19 m"]
    first = why_not(tracks, before, "R2", flinch)
    assert [held.text for held in first.held] == ["around < min(flinch_near, to_goal)"]
    second = why_not(tracks, after, "R2", flinch)
    assert [held.text for held in second.held] == ["around < flinch_near"]
    assert second.held[0].right == pytest.approx(0.19)
    assert tracks.curve("R2", "compare", f"{flinch}\n1").at(after)[1:] == pytest.approx([7.0, 1.0])
    assert why_not(tracks, before, "R2", avoid).held
    gone = why_not(tracks, after, "R2", avoid).because
    assert gone == "its rule file was replaced, and the new one does not have it"
