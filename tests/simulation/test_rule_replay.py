"""Rules on recordings do what the live rules do, sample by sample, through every change of mode."""

import numpy as np
import pytest

from rocs_bt.base.signal import Signal
from rocs_bt.base.units import LENGTH, SPEED
from rocs_bt.catalog import Catalog
from rocs_bt.event import RuleChanged
from rocs_bt.reactive import RuleModel
from rocs_bt.record import AgentInfo, Recorder, Recording, RunHeader, SignalInfo
from rocs_bt.running.rule_replay import (
    ReflexInput,
    reflex_input,
    replay_rules,
    rules_for,
    sweep_threshold,
    threshold_dimension,
)

R1 = AgentInfo(
    name="R1",
    robot="nobodys",
    mission="m",
    signals=(SignalInfo.of(Signal("front", 2, (LENGTH,))), SignalInfo.of(Signal("speed", 1, (SPEED,)))),
)
RULES = """
format = "reflex/1"
[threshold]
near = "0.5 m"
[rule.Near]
when = "min(front) < near and once(speed > 0.5 m/s, 0.2 s)"
until = "min(front) > near + 0.1 m"
for = "0.05 s"
cooldown = "0.2 s"
priority = 1
modes = ["drive"]
action = { name = "TurnAngle", angle = "60 deg" }
[rule.Fast]
when = "speed > 0.7 m/s"
on_invalid = "trip"
trigger = "level"
priority = 2
action = { name = "Stop" }
"""


@pytest.fixture
def file(tmp_path):
    file = tmp_path / "rules" / "mine.toml"
    file.parent.mkdir()
    file.write_text(RULES, "utf-8")
    return file


def seen(seed, count=300):
    rng = np.random.default_rng(seed)
    x = rng.uniform(0.2, 1.0, (count, 3))
    x[rng.uniform(size=x.shape) < 0.05] = np.nan
    modes = np.repeat(rng.choice(["", "drive", "dock"], count // 10), 10)
    return ReflexInput("run-1", R1, np.arange(count) * 0.05, x, tuple(modes.tolist()), {})


@pytest.mark.parametrize("seed", range(5))
def test_it_is_what_the_live_rules_do(seed, file):
    rules, given = rules_for(file, R1, Catalog()), seen(seed)
    found, model, changes = replay_rules(rules, given), RuleModel(rules), 0
    for k, (t, x, mode) in enumerate(zip(given.t.tolist(), given.x, given.modes, strict=True)):
        model.enter(mode)
        model.react(x, t)
        on = tuple(r.name for r, on in zip(rules.rules, found.steps.mask[k], strict=True) if on)
        changes += k > 0 and bool((found.steps.mask[k] != found.steps.mask[k - 1]).any())
        assert on == model.latched, t
        best = max((r for r in rules.rules if r.name in on), key=lambda r: r.priority, default=None)
        assert found.steps.winner[k] == (-1 if best is None else rules.rules.index(best))
    assert changes > 20
    assert len(found.firings) > 10


def test_what_a_firing_says(file):
    x = np.array([[0.4, 1.0, 0.6]] * 3 + [[0.7, 1.0, 0.6]])
    given = ReflexInput("run-1", R1, np.array([0.0, 0.1, 0.2, 0.3]), x, ("drive",) * 4, {})
    (firing,) = replay_rules(rules_for(file, R1, Catalog()), given).firings
    assert (firing.rule, firing.begin, firing.end) == ("mine/Near", 0.1, 0.3)
    assert firing.won == pytest.approx(0.2)
    assert firing.reading == "min(front) = 0.4 m, speed = 0.6 m/s"


def test_the_runs_own_latches_are_those_of_the_agent(tmp_path):
    recorder = Recorder(tmp_path / "run.mcap", RunHeader(scenario="x", seed=1, agents=(R1,)))
    for k, phase in enumerate(("latched", "fired", "fired again", "released", "latched")):
        for agent, rule in (("R1", "mine/Near"), ("R1", "mine/Fast"), ("R2", "mine/Near")):
            recorder.emit(
                RuleChanged(t=k + 0.5 * (rule == "mine/Fast"), agent=agent, rule=rule, phase=phase, priority=1)
            )
    recorder.close()
    found = reflex_input(Recording.open(recorder.path), R1)
    assert found.latched == {"mine/Near": (0.0, 4.0), "mine/Fast": (0.5, 4.5)}
    assert (found.t.shape, found.x.shape) == ((0,), (0, 3))


def test_a_recording_without_a_sample(file):
    given = ReflexInput("run-1", R1, np.empty(0), np.empty((0, 3)), (), {})
    found = replay_rules(rules_for(file, R1, Catalog()), given)
    assert (found.firings, found.steps.mask.shape) == ((), (0, 2))


def test_a_sweep_loads_the_rules_anew_for_each_value(file):
    given = [seen(1), seen(2)]
    rules = rules_for(file, R1, Catalog())
    dimension = threshold_dimension("near", rules)
    assert dimension == LENGTH
    counts = sweep_threshold(
        file, given, Catalog(), rule="Near", threshold="near", values=[0.1, 0.5], dimension=dimension
    )
    assert counts[0].tolist() == [0.0, 0.0]
    wanted = [sum(f.rule == "mine/Near" for f in replay_rules(rules, g).firings) for g in given]
    assert counts[1].tolist() == wanted
    assert min(wanted) > 0
