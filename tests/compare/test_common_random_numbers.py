"""Another planner changes nothing but what it decides: starts, noise and actors of a scenario and a seed stay."""

from __future__ import annotations

import numpy as np
import pytest

from rocs_bt import run
from rocs_bt.base.errors import RecordingError
from rocs_bt.catalog import Catalog, PlannerSpec
from rocs_bt.declare import replaced
from rocs_bt.event import ActuatorCommanded, BodyMoved, ListSink, RuleChanged, SensorRead, TicketChanged
from rocs_bt.record import Recording
from rocs_bt.running import replay

CATALOG = Catalog()
TREE, NONE, RANDOM = (CATALOG.load_planner(name) for name in ("tree", "none", "random"))


def events(planner, seed=3, scenario="exp1", agent="R2", duration=3.0):
    sink = ListSink()
    spec = planner.drives(CATALOG.load_scenario(scenario), agent)
    run(spec, CATALOG, seed=seed, duration=duration, sinks=[sink])
    return sink.events


def starts(found):
    return {e.body: (e.x, e.y, e.yaw) for e in found if isinstance(e, BodyMoved) and e.t == 0.0}


def way(found, body):
    return [(e.t, e.x, e.y, e.yaw) for e in found if isinstance(e, BodyMoved) and e.body == body]


def test_starts_and_scripted_actors_are_the_same_for_every_planner_and_others_for_another_seed():
    tree, none, random = (events(planner) for planner in (TREE, NONE, RANDOM))
    assert starts(tree) == starts(none) == starts(random)
    assert way(tree, "R1") == way(none, "R1") == way(random, "R1")  # nobody touches it in this time
    assert way(tree, "R2") != way(none, "R2")
    assert starts(events(TREE, seed=4)) != starts(tree)


def test_the_noise_of_each_sensor_is_the_same_for_every_planner():
    """The noise is what a sensor says in a run with noise less what it says in the same run without."""

    def noise(planner):
        catalog = Catalog()
        spec = planner.drives(catalog.load_scenario("exp1_localised"), "R2")
        read = {}
        for noisy in (True, False):
            quiet = _QuietCatalog() if not noisy else catalog
            sink = ListSink()
            run(spec, quiet, seed=5, duration=0.04, sinks=[sink])  # one period: nobody has moved yet
            read[noisy] = {e.sensor: np.array(e.values) for e in sink.events if isinstance(e, SensorRead)}
        with np.errstate(invalid="ignore"):  # no echo in either
            return {name: read[True][name] - read[False][name] for name in read[True]}

    tree, none = noise(TREE), noise(NONE)
    assert any(np.abs(n[np.isfinite(n)]).max(initial=0.0) > 0.0 for n in tree.values())
    for name in tree:
        np.testing.assert_array_equal(tree[name], none[name])


class _QuietCatalog(Catalog):
    """Robots whose sensors have no noise."""

    def load_robot(self, name):
        robot = super().load_robot(name)
        return replaced(robot, sensors=tuple(replaced(s, noise=0.0) for s in robot.sensors))


def test_the_streams_draw_the_same_number_of_times_whatever_the_planner_does():
    """A stands-still planner and one that draws itself: the generators of all sensors end in the same state."""
    states = []
    for planner in (NONE, RANDOM, TREE):
        generators = {}

        def keep(stage, generators=generators):
            generators.update({n: s.rng for n, s in stage.sensors["R2"].items() if hasattr(s, "rng")})

        spec = planner.drives(CATALOG.load_scenario("exp1_localised"), "R2")
        run(spec, CATALOG, seed=2, duration=2.0, prepare=keep)
        states.append({name: rng.bit_generator.state for name, rng in generators.items()})
    assert states[0]
    assert states[0] == states[1] == states[2]


def test_a_latency_delays_the_plan_and_no_reflex():
    slow = replaced(TREE, latency=0.3)
    tickets = {}
    for name, planner in (("fast", TREE), ("slow", slow)):
        found = events(planner, duration=10.0)
        tickets[name] = [e for e in found if isinstance(e, TicketChanged)]
        waits = {"NORMAL": [], "HIGH": []}
        queued = {}
        for e in tickets[name]:
            if e.state == "QUEUED":
                queued[e.ticket] = e.t
            elif e.state == "RUNNING":
                waits[e.priority].append(e.t - queued[e.ticket])
        fired = [e.t for e in found if isinstance(e, RuleChanged) and e.phase == "fired"]
        acted = [e.t for e in tickets[name] if e.priority == "HIGH" and e.state == "RUNNING"]
        assert waits["NORMAL"] == pytest.approx([0.3 if name == "slow" else 0.0] * len(waits["NORMAL"]))
        assert len(waits["HIGH"]) >= 2
        assert max(waits["HIGH"]) == 0.0
        assert set(fired) <= set(acted)
    first = {name: next(e.t for e in tickets[name] if e.state == "RUNNING") for name in tickets}
    assert first == {"fast": 0.0, "slow": pytest.approx(0.3)}


def test_a_robot_goes_on_while_its_planner_thinks():
    """A Python planner decides anew each turn; with a latency it is driven in every period from then on."""
    for latency in (0.0, 0.25):
        found = events(replaced(RANDOM, latency=latency), duration=2.0)
        commands = [e for e in found if isinstance(e, ActuatorCommanded) and e.agent == "R2" and e.t < 1.99]
        driven = [e.t for e in commands if e.route == "deliberative"]
        assert driven == pytest.approx([0.05 * k for k in range(round(latency / 0.05), 40)])


@pytest.fixture
def thinking(tmp_path):
    """A catalog with EXP1, named 'slow', whose planner thinks as long as is given."""

    def write(latency):
        text, rules = CATALOG.find("scenario", "exp1").path.read_text(), 'rules = ["avoid_collision"]'
        (tmp_path / "scenarios").mkdir()
        (tmp_path / "scenarios" / "slow.toml").write_text(text.replace(rules, f'{rules}\nlatency = "{latency}"'))
        return Catalog(tmp_path)

    return write


def test_a_declared_latency_repeats_and_can_be_replayed(tmp_path, thinking):
    catalog = thinking("0.2 s")
    runs = [run("slow", catalog, seed=2, out=tmp_path / out, report=False, duration=4.0) for out in ("a", "b")]
    assert runs[0].summary.trajectory_hash == runs[1].summary.trajectory_hash
    assert replay(Recording.open(tmp_path / "a"), catalog) is None
    assert catalog.load_scenario("slow").agents[0].latency == 0.2


def test_a_measured_latency_cannot_be_replayed_and_says_so(tmp_path, thinking):
    catalog = thinking("measured")
    assert catalog.load_scenario("slow").agents[0].latency is None
    run("slow", catalog, out=tmp_path / "run", report=False, duration=1.0)
    with pytest.raises(RecordingError, match="was measured"):
        replay(Recording.open(tmp_path / "run"), catalog)


def test_a_measured_latency_is_what_the_planner_takes(monkeypatch):
    """A planner that takes 60 ms each time is late by that, rounded up to control periods."""
    monkeypatch.setattr("rocs_bt.running.simulated_stage.time", Stopwatch)
    monkeypatch.setattr(Stopwatch, "now", 0.0)
    catalog = Catalog()
    planner = PlannerSpec(name="slow", mission=f"{__file__}:Burns", latency=None)
    sink = ListSink()
    run(planner.drives(catalog.load_scenario("exp1"), "R2"), catalog, duration=0.6, sinks=[sink])
    starts = [e for e in sink.events if isinstance(e, TicketChanged) and e.state in ("QUEUED", "RUNNING")]
    queued = {e.ticket: e.t for e in starts if e.state == "QUEUED"}
    waits = [e.t - queued[e.ticket] for e in starts if e.state == "RUNNING"]
    assert waits
    assert waits == pytest.approx([0.1] * len(waits))


class Stopwatch:
    """Stands in for the module `time`: only what `Burns` takes passes."""

    now = 0.0

    @classmethod
    def perf_counter(cls):
        return cls.now


class Burns:
    """Takes 60 ms by the stopwatch."""

    def reset(self, task, rng):
        """Nothing."""

    def act(self, observation):
        """Take so long; this file is loaded once more as content, so the stopwatch is found where it was put."""
        from rocs_bt.running import simulated_stage

        simulated_stage.time.now += 0.06
        return 0.1, 0.1
