"""TreePlan, Plan, conditions and waits."""

import pytest
from py_trees.behaviour import Behaviour
from py_trees.behaviours import Running
from py_trees.common import ParallelPolicy, Status
from py_trees.composites import Parallel, Selector, Sequence

from rocs_bt.base.errors import InputError
from rocs_bt.base.geometry import Pose2
from rocs_bt.event import Change, NodeTicked
from rocs_bt.interfaces.channel import Publisher
from rocs_bt.plan import Plan
from rocs_bt.plan.plan import RUNNING


def front(mind, value):
    mind.rig.knowledge.signals.write("front", [value], mind.rig.clock.now())


def test_only_changes_of_status_are_told_by_path_children_first(mind):
    mind.rig.knowledge.world.place("goal", Pose2(0.3, 0.0), kind="goal")
    children = [mind.mission.wait("0.1 s"), mind.mission.wait(0.1), mind.mission.act("GoTo", goal="goal")]
    mind.start(Sequence("go", memory=True, children=children))
    mind.until_done()
    seen = [(e.node, e.status) for e in mind.rig.of(NodeTicked)]
    assert seen == [
        ("go/wait 0.1 s", "RUNNING"),
        ("go", "RUNNING"),
        ("go/wait 0.1 s#2", "RUNNING"),
        ("go/wait 0.1 s", "SUCCESS"),
        ("go/GoTo goal", "RUNNING"),
        ("go/wait 0.1 s#2", "SUCCESS"),
        ("go/GoTo goal", "SUCCESS"),
        ("go", "SUCCESS"),
    ]


def test_a_change_calls_for_a_tick_and_a_tick_answers_it(mind):
    plan = mind.start(Running("wait"))
    publisher = Publisher("obstacle")
    publisher.connect(plan.inbox)
    assert not plan.called
    publisher.publish(0.0, Change(t=0.0, source="obstacle", kind="obstacle"))
    assert plan.called
    plan.run(0.0)
    assert not plan.called


def test_so_does_asking_for_a_new_plan(mind):
    plan = mind.start(Running("wait"))
    plan.replan("rules/Flinch ended")
    assert plan.called
    plan.run(0.0)
    assert not plan.called


def test_nodes_are_set_up_and_shut_down_once(mind):
    calls = []

    class Node(Running):
        def setup(self, **kwargs):
            calls.append(("setup", self.name))

        def shutdown(self):
            calls.append(("shutdown", self.name))

    plan = mind.start(Sequence("a", memory=True, children=[Node("b")]))
    plan.close()
    assert calls == [("setup", "b"), ("shutdown", "b")]


class TestConditions:
    def test_what_is_not_known_does_not_hold_either_way(self, mind):
        leaves = [mind.mission.when("front > 0.5 m"), mind.mission.when("front <= 0.5 m")]
        plan = mind.start(Selector("either", memory=False, children=leaves))
        mind.run()
        assert plan.status == "FAILURE"
        assert "front = invalid" in plan.reason

    def test_all_conditions_of_a_tick_see_the_same_snapshot(self, mind):
        front(mind, 0.3)
        leaves = [mind.mission.when("front < 0.5 m"), Sneak(mind), mind.mission.when("front < 0.5 m", name="still")]
        plan = mind.start(Sequence("same", memory=True, children=leaves))
        mind.run()
        assert plan.status == "SUCCESS"


class Sneak(Running):
    """Writes a signal in the midst of a tick."""

    def __init__(self, mind):
        super().__init__("sneak")
        self.mind = mind

    def update(self):
        front(self.mind, 9.0)
        return Status.SUCCESS


class TestWait:
    @pytest.mark.parametrize(("duration", "ticks"), [(0.0, 1), (0.1, 2), (0.25, 4), ("1 s", 11), ("500 ms", 6)])
    def test_it_reads_the_injected_clock(self, mind, duration, ticks):
        plan = mind.start(mind.mission.wait(duration))
        mind.until_done()
        assert plan.ticks == ticks


class TestUsersPlan:
    """Paper, 5.3: a user's class implements `run`."""

    class Patrol(Plan):
        places = ("a", "b")
        ticket = None
        round = 0

        def run(self, t):
            self.kinds = [c.value.kind for c in self.changes()]
            if self.ticket is None or self.ticket.state.done:
                if self.round == len(self.places):
                    self.status = "SUCCESS"
                    return
                self.ticket = self.submit("GoTo", goal=self.places[self.round])
                self.round += 1

    @pytest.fixture
    def patrol(self, mind):
        rig = mind.rig
        rig.knowledge.world.place("a", Pose2(0.5, 0.0))
        rig.knowledge.world.place("b", Pose2(0.5, 0.5))
        mind.plan = self.Patrol(
            "patrol",
            knowledge=rig.knowledge,
            pipeline=rig.pipeline,
            actions=rig.actions,
            clock=rig.clock,
            sink=rig.sink,
        )
        return mind.plan

    def test_it_drives_the_robot(self, mind, patrol):
        assert patrol.status == RUNNING
        mind.until_done()
        assert mind.rig.pose.distance(Pose2(0.5, 0.5)) < 0.06


class Rotten(Behaviour):
    """Does what a test says, and writes down how it ended."""

    def __init__(self, name, update, log=None):
        super().__init__(name)
        self.log = [] if log is None else log
        self._update = update

    def update(self):
        return self._update()

    def terminate(self, new_status):
        if new_status is Status.INVALID and self.status is Status.RUNNING:
            self.log.append((self.name, "halted"))

    def shutdown(self):
        self.log.append((self.name, "shut down"))
        if self.name == "rotten":
            raise RuntimeError("it does not let go")


@pytest.mark.parametrize("wrong", [None, True, "SUCCESS", Status.INVALID])
@pytest.mark.parametrize("composite", [Sequence, Selector])
def test_a_leaf_that_gives_no_status_back_is_named_and_nothing_is_printed(mind, capfd, wrong, composite):
    leaf = Rotten("b", lambda: wrong)
    root = composite("root", memory=True, children=[leaf, Running("c")])
    plan = mind.start(root)
    with pytest.raises(InputError, match=r"update of 'root/b' \(Rotten\) returned no status. Return Status.RUNNING"):
        plan.run(0.0)
    assert "".join(capfd.readouterr()) == ""


def test_closing_halts_what_runs_and_shuts_down_every_node(mind):
    log = []
    a, b = (Rotten(name, lambda: Status.RUNNING, log) for name in ("rotten", "b"))
    plan = mind.start(Parallel("root", ParallelPolicy.SuccessOnAll(), [a, b]))
    plan.run(0.0)
    with pytest.raises(RuntimeError, match="does not let go"):
        plan.close()
    assert log == [("rotten", "halted"), ("b", "halted"), ("rotten", "shut down"), ("b", "shut down")]
    last = {e.node: e.status for e in mind.rig.of(NodeTicked)}
    assert last == {"root": "INVALID", "root/rotten": "INVALID", "root/b": "INVALID"}


def test_so_it_does_after_a_tick_that_raised_half_way(mind):
    mind.rig.knowledge.world.place("goal", Pose2(3.0, 0.0), kind="goal")
    go, leaf = mind.mission.act("GoTo", goal="goal"), Rotten("b", lambda: 1 / 0)
    plan = mind.start(Parallel("root", ParallelPolicy.SuccessOnAll(synchronise=False), [go, leaf]))
    with pytest.raises(ZeroDivisionError):
        plan.run(0.0)
    assert go.status is Status.RUNNING
    plan.close()
    assert (go.status, go.ticket.cancelled_by) == (Status.INVALID, "root/GoTo goal")
    assert not mind.rig.pipeline.queued()
