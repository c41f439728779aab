"""Content that raises: the robot brakes, the exception is reported with its line, and the plan is asked again."""

import math
from asyncio import CancelledError
from dataclasses import dataclass

import pytest
from py_trees.behaviour import Behaviour
from py_trees.common import ParallelPolicy, Status
from py_trees.composites import Parallel

from rocs_bt.catalog import Catalog
from rocs_bt.event import (
    ActuatorCommanded,
    BlockFailed,
    ContentRaised,
    RuleChanged,
    SignalsWritten,
    TicketChanged,
)
from rocs_bt.interfaces.action import AtomicAction, MacroAction, Progress
from rocs_bt.monitor import RangeMonitor
from rocs_bt.plan import Plan, RoutePlanner, python_mission
from rocs_bt.reactive import ReactiveModel, Reflex
from rocs_bt.record import Recording
from rocs_bt.running import replay
from rocs_bt.testing.faults import RaisingSensor, break_sensor
from rocs_bt.trees.nodes import Leaf

AT = 1.0  # [s] when it happens: the robot drives by then, and no reflex is active


class Rotten(RuntimeError):
    """What the content here raises."""


class Times:
    """Raises at some of the times at which it is asked, once at each; for ever from the last one on if `on`."""

    error = Rotten

    def __init__(self, *times, on=False):
        self.left, self.on = list(times), on

    def check(self, t):
        if self.left and t >= self.left[0] - 1e-9:
            if len(self.left) > 1 or not self.on:
                self.left.pop(0)
            raise self.error("a worm")


LINE = Times.check.__code__.co_firstlineno + 4


class Raises:
    """What raises in `update`."""

    def __init__(self, mission, times):
        super().__init__("leaf")
        self.mission, self.times = mission, times

    def update(self):
        self.times.check(self.mission.clock.now())
        return Status.RUNNING


class StockLeaf(Raises, Behaviour):
    """A leaf of py_trees' own kind."""


class OwnLeaf(Raises, Leaf):
    """A leaf of ours."""


class RottenRoutes(RoutePlanner):
    """A route planner, asked by a leaf."""

    def route(self, start, goal, clearance):
        self.times.check(self.knowledge.clock.now())
        return [start[:2], goal[:2]]


class Router(StockLeaf):
    """A leaf that asks a route planner."""

    def __init__(self, mission, times):
        super().__init__(mission, times)
        self.routes = RottenRoutes(mission.knowledge)
        self.routes.times = times

    def update(self):
        world, robot = self.mission.knowledge.world, self.mission.knowledge.robot
        self.routes.route(robot.pose(self.mission.clock.now()), world.pose_of("goal"), 0.1)
        return Status.RUNNING


@dataclass
class Straight:
    """A planner that is no tree."""

    times: Times

    def reset(self, task, rng):
        pass

    def act(self, observation):
        self.times.check(observation.t)
        return 0.2, 0.2


class Own(Plan):
    """A user's own Plan."""

    ticket = times = None

    def run(self, t):
        self.changes()
        self.times.check(t)
        if self.ticket is None or self.ticket.state.done:
            self.ticket = self.submit("GoTo", goal="goal")


class Rot(AtomicAction):
    """An action that drives."""

    def act(self, body):
        TIMES[0].check(body.clock.now())
        body.motion.command([0.2, 0.2])
        return Progress.RUNNING


class Rots(MacroAction):
    """A macro-action that drives, in pieces."""

    def decompose(self, body):
        while True:
            TIMES[0].check(body.clock.now())
            yield Nudge()


class Nudge(AtomicAction):
    """An action that drives for one period."""

    def act(self, body):
        body.motion.command([0.2, 0.2])
        return Progress.SUCCEEDED


TIMES = [Times()]
"""When the actions raise."""


def beside(leaf):
    def build(mission, times):
        leaves = [mission.act("GoTo", goal="goal"), leaf(mission, times)]
        return Parallel("both", ParallelPolicy.SuccessOnOne(), leaves)

    return build


def own_plan(mission, times):
    plan = Own("mine", **mission.parts)
    plan.times = times
    return plan


MISSIONS = {
    "leaf of py_trees": ("leaf", "both/leaf", beside(StockLeaf)),
    "leaf": ("leaf", "both/leaf", beside(OwnLeaf)),
    "route planner": ("route planner", "RottenRoutes", beside(Router)),
    "planner": ("planner", "Straight", lambda mission, times: python_mission(Straight)(mission, times=times)),
    "plan": ("planner", "mine", own_plan),
    "action": ("action", "Rot", lambda mission, times: mission.act("Rot")),
    "macro-action": ("action", "Rots", lambda mission, times: mission.act("Rots")),
}


@pytest.fixture
def raising(broken):
    """Runs EXP1 with content that raises at some times."""

    def raising(what, *times, on=False, **kwargs):
        kind, name, make = MISSIONS[what]
        TIMES[0] = Times(*times, on=on)

        def build(mission):
            return make(mission, TIMES[0])

        return kind, name, broken(missions={"R2": build}, **kwargs)

    return raising


@pytest.mark.parametrize("what", MISSIONS)
def test_the_first_exception_brakes_and_the_plan_is_asked_again(what, raising, tmp_path):
    kind, name, run = raising(what, AT, duration=1.6, rules=(), out=tmp_path)
    (event,) = run.of(ContentRaised)
    assert (event.kind, event.content, event.detail) == (kind, name, "Rotten: a worm")
    assert (event.file, event.line) == ("test_content.py", LINE)
    assert event.effect == "brakes and replans (1 of 3 within 10 s)"
    commands = {e.t: any(e.values) for e in run.of(ActuatorCommanded)}
    assert [moves for t, moves in commands.items() if AT - 0.2 < t < AT + 0.25] == [True] * 3 + [False] + [True] * 4
    assert not commands[event.t]
    assert run.agent.exceptions == {f"{kind} {name}": 1}
    assert run.agent.outcome != "failed"
    assert run.agent.failed_block is None
    assert not run.of(BlockFailed)
    if what not in ("planner", "plan"):
        assert run.agent.replans >= 1
    recorded = [e for e in Recording.open(tmp_path).events() if isinstance(e, ContentRaised)]
    assert recorded == [event]


@pytest.mark.parametrize("what", MISSIONS)
def test_the_third_exception_within_ten_seconds_fails_the_mission(what, raising):
    kind, name, run = raising(what, AT, on=True, duration=20.0, rules=())
    events = run.of(ContentRaised)
    assert [e.effect.split(" (")[0] for e in events] == ["brakes and replans"] * 2 + ["the mission fails"]
    assert run.agent.outcome == "failed"
    reason = f"{kind} '{name}' raised Rotten: a worm (test_content.py:{LINE}); 3 exceptions within 10 s"
    assert run.agent.reason == f"the mission failed: {reason}"
    assert run.agent.exceptions == {f"{kind} {name}": 3}
    assert run.result.summary.sim_time < events[0].t + 2.0
    assert not [e for e in run.of(ActuatorCommanded) if e.t > events[0].t and any(e.values)]
    assert run.coast() < 0.02
    states = {e.ticket: e.state for e in run.of(TicketChanged)}
    assert set(states.values()) <= {"SUCCEEDED", "FAILED", "CANCELLED"}  # every ticket ended


@pytest.mark.parametrize("mode", ["lockstep", "threaded"])
@pytest.mark.parametrize("what", ["leaf of py_trees", "leaf", "action"])
def test_a_cancellation_of_asyncio_counts_too(what, mode, raising, monkeypatch, awake):
    monkeypatch.setattr(Times, "error", CancelledError)  # no Exception, but a BaseException
    kind, name, run = raising(what, AT, on=True, duration=5.0, rules=(), mode=mode)
    assert run.agent.outcome == "failed"
    reason = f"{kind} '{name}' raised CancelledError: a worm (test_content.py:{LINE}); 3 exceptions within 10 s"
    assert run.agent.reason == f"the mission failed: {reason}"


@pytest.mark.parametrize(("apart", "outcome"), [(5.05, "success"), (4.95, "failed")])
def test_exceptions_further_apart_do_not_fail_the_mission(apart, outcome, raising):
    _, _, run = raising("leaf", AT, AT + apart, AT + 2 * apart, duration=20.0)
    assert len(run.of(ContentRaised)) == 3
    assert run.agent.outcome == outcome


@pytest.mark.parametrize("what", MISSIONS)
def test_a_replay_raises_the_same(what, raising, tmp_path):
    _, _, run = raising(what, AT, 2 * AT, duration=4.0, out=tmp_path)
    assert len(run.of(ContentRaised)) == 2
    TIMES[0] = Times(AT, 2 * AT)
    make = MISSIONS[what][2]
    assert replay(Recording.open(tmp_path), Catalog(), missions={"R2": lambda mission: make(mission, TIMES[0])}) is None


def signals(run, monitor, since, until):
    """What a monitor wrote in a time, one list a period."""
    return [e.values for e in run.of(SignalsWritten) if e.monitor == monitor and since - 1e-9 <= e.t < until - 1e-9]


def invalid(values):
    return all(math.isnan(v) for row in values.values() for v in row)


def test_a_sensor_that_raises_has_invalid_signals_and_is_read_again(broken, tmp_path):
    run = broken(
        lambda stage: break_sensor(stage, "sonar", RaisingSensor, at=AT, until=2 * AT), out=tmp_path, duration=40.0
    )
    (event,) = run.of(ContentRaised)
    assert (event.kind, event.content) == ("sensor", "sonar")
    assert event.detail == "RuntimeError: the driver of 'sonar' has a defect"
    assert event.effect.startswith("its signals are invalid")
    assert (event.t, event.file) == (AT, "faults.py")
    broken_values, sound = signals(run, "range", AT, 2 * AT), signals(run, "range", 2 * AT, 3 * AT)
    assert len(broken_values) == 20
    assert all(map(invalid, broken_values))
    assert not any(map(invalid, sound))
    assert run.agent.exceptions == {"sensor sonar": 1}
    assert [e for e in run.of(RuleChanged) if e.phase == "fired" and e.rule.endswith("Blind") and e.t < AT + 0.11]
    assert run.agent.outcome == "success"
    assert replay_of(tmp_path, until=2 * AT + 0.5) is None


def replay_of(folder, until):
    """Where a replay of EXP1 as it is shipped differs; None where it is the same."""
    recording = Recording.open(folder)
    assert list(recording.events())[-1].t > until
    return replay(recording, Catalog())


def test_a_sensor_that_never_worked_has_no_signals_at_all(broken, tmp_path):
    run = broken(lambda stage: break_sensor(stage, "sonar", RaisingSensor), out=tmp_path, duration=1.0)
    assert run.agent.exceptions == {"sensor sonar": 1}
    assert not run.of(BlockFailed)
    assert not run.touched
    assert replay(Recording.open(tmp_path), Catalog()) is None


@pytest.mark.parametrize("method", ["interpret", "stamp", "reject"])
def test_a_monitor_that_raises_has_invalid_signals_and_is_asked_again(method, broken, monkeypatch):
    stages, sound = [], getattr(RangeMonitor, method)

    def rotten(self, *args):
        if stages and AT <= stages[0].clock.now() < 2 * AT:
            raise Rotten("a worm")
        return sound(self, *args)

    monkeypatch.setattr(RangeMonitor, method, rotten)
    run = broken(stages.append, duration=40.0)
    (event,) = run.of(ContentRaised)
    assert (event.kind, event.content, event.t, event.file) == ("monitor", "range", AT, "test_content.py")
    assert event.line == rotten.__code__.co_firstlineno + 2
    assert all(map(invalid, signals(run, "range", AT, 2 * AT)))
    assert not any(map(invalid, signals(run, "range", 2 * AT, 3 * AT)))
    assert run.agent.outcome == "success"


def test_each_onset_is_reported_once_and_counted(broken):
    def prepare(stage):
        for at in (1.0, 1.5, 2.0):
            break_sensor(stage, "sonar", RaisingSensor, at=at, until=at + 0.2)

    assert broken(prepare, duration=3.0).agent.exceptions == {"sensor sonar": 3}


class Whim(ReactiveModel):
    """Wants an action for a while."""

    def __init__(self, action, level):
        self.action, self.level = action, level

    def react(self, x, t):
        wanted = AT - 1e-9 <= t < 2 * AT - 1e-9
        return [Reflex("whim", 50, self.action, level=self.level)] if wanted else []


class Unmakeable(AtomicAction):
    """An action that raises when it is made."""

    def __post_init__(self):
        raise Rotten("a worm")

    def act(self, body):
        return Progress.SUCCEEDED


@pytest.mark.parametrize("level", [True, False])
@pytest.mark.parametrize("action", ["Rot", "Rots", "Unmakeable"])
def test_a_reflex_whose_action_raises_stops_until_its_latch_is_clear(action, level, broken):
    TIMES[0] = Times(AT, on=True)

    def build(mission):
        mission.knowledge.reactive_models.append(Whim(action, level))
        return mission.act("GoTo", goal="goal")

    run = broken(missions={"R2": build}, rules=(), duration=2.4)
    (event,) = run.of(ContentRaised)
    assert (event.kind, event.content) == ("reflex action", action)
    assert event.effect == "stops until the latch of the rule clears"
    phases = [e.phase for e in run.of(RuleChanged)]
    assert phases == ["latched", "fired", "stopped", "released", "ended"]
    commands = {e.t: any(e.values) for e in run.of(ActuatorCommanded)}
    assert not any(moves for t, moves in commands.items() if AT - 1e-9 <= t < 2 * AT - 1e-9)
    assert any(moves for t, moves in commands.items() if t >= 2 * AT + 0.1)
    assert run.agent.outcome != "failed"
    assert run.agent.exceptions == {f"reflex action {action}": 1}
    assert {e.action for e in run.of(TicketChanged) if e.priority == "HIGH"} == {action, "Stop"} - {"Unmakeable"}


class Unsound(ReactiveModel):
    """Asks for a reflex once, then raises for a second."""

    def __init__(self, raises):
        self.raises = raises

    def react(self, x, t):
        if t < AT - 1e-9 or t >= 2 * AT - 1e-9:
            return []
        return self.raises()


def unsound():
    raise Rotten("a worm")


def calls_for_an_exit():
    raise SystemExit(3)


@pytest.mark.parametrize(
    ("raises", "detail"),
    [
        (unsound, "Rotten: a worm"),
        (calls_for_an_exit, "SystemExit(3)"),
        (lambda: None, "TypeError: 'NoneType' object is not iterable"),
        (lambda: ["Stop"], "TypeError: react must return a list of Reflex, found an item 'Stop'"),
    ],
)
def test_a_reactive_model_that_raises_stops_the_robot_until_it_no_longer_raises(raises, detail, broken, tmp_path):
    def build(mission):
        mission.knowledge.reactive_models.append(Unsound(raises))
        return mission.act("GoTo", goal="goal")

    run = broken(missions={"R2": build}, rules=(), duration=2.4, out=tmp_path)
    (event,) = run.of(ContentRaised)
    assert (event.kind, event.content, event.detail, event.t) == ("reactive model", "Unsound", detail, AT)
    assert event.effect == "stops until the model no longer raises"
    assert (event.file, event.line > 0) == ("test_content.py", True)
    assert [(e.rule, e.phase) for e in run.of(RuleChanged)] == [
        ("Unsound/Raised", phase) for phase in ("latched", "fired", "stopped", "released", "ended")
    ]
    commands = {e.t: any(e.values) for e in run.of(ActuatorCommanded)}
    assert not any(moves for t, moves in commands.items() if AT - 1e-9 <= t < 2 * AT - 1e-9)
    assert any(moves for t, moves in commands.items() if t >= 2 * AT + 0.1)
    assert run.agent.exceptions == {"reactive model Unsound": 1}
    assert run.agent.outcome not in ("failed", "error")


def test_a_reflex_of_higher_priority_acts_though_another_model_raises(broken):
    def build(mission):
        mission.knowledge.reactive_models += [Unsound(unsound), Whim("Nudge", level=True)]
        return mission.act("GoTo", goal="goal")

    run = broken(missions={"R2": build}, rules=(), duration=1.5)
    assert {e.action for e in run.of(TicketChanged) if e.priority == "HIGH"} == {"Nudge"}
    assert [e.rule for e in run.of(RuleChanged) if e.phase == "waits"] == ["Unsound/Raised"]


def test_a_reflex_acts_though_its_reading_raises(broken):
    class Speechless(ReactiveModel):
        def react(self, x, t):
            return [Reflex("speechless", 50, "Nudge", level=True, reading=unsound)] if t >= AT - 1e-9 else []

    def build(mission):
        mission.knowledge.reactive_models.append(Speechless())
        return mission.act("GoTo", goal="goal")

    run = broken(missions={"R2": build}, rules=(), duration=1.5)
    (fired,) = [e for e in run.of(RuleChanged) if e.phase == "fired"]
    line = unsound.__code__.co_firstlineno + 1
    assert fired.reading == f"reading 'speechless' raised Rotten: a worm (test_content.py:{line})"
    assert {e.action for e in run.of(TicketChanged) if e.priority == "HIGH"} == {"Nudge"}


def test_a_reflex_acts_in_its_period_though_the_action_that_it_cuts_off_raises_when_it_is_stopped(broken):
    class Clings(AtomicAction):
        def act(self, body):
            body.motion.command([0.2, 0.2])
            return Progress.RUNNING

        def stop(self, body):
            raise Rotten("it clings")

    def build(mission):
        mission.actions = {**mission.actions, "Clings": Clings}
        mission.knowledge.reactive_models.append(Whim("Nudge", level=False))
        return mission.act("Clings")

    run = broken(missions={"R2": build}, rules=(), duration=AT + 0.3)
    assert run.agent.exceptions == {"action Clings": 1}
    routes = {e.t: e.route for e in run.of(ActuatorCommanded) if any(e.values)}
    assert routes[AT] == "reactive"
