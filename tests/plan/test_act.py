"""The Act leaf: submit, wait, be pre-empted, be halted, give up."""

import pytest
from py_trees.common import Status
from py_trees.composites import Selector

from rocs_bt.actions import Flinch, SetWheelSpeed
from rocs_bt.base.geometry import Pose2
from rocs_bt.event import Replanned
from rocs_bt.interfaces.action import Reason
from rocs_bt.interfaces.pipeline import TicketState


@pytest.fixture
def goal(rig):
    rig.knowledge.world.place("goal", Pose2(2.0, 0.0), kind="goal")
    return "goal"


def test_it_runs_while_the_action_does_and_succeeds_with_it(mind, goal):
    leaf = mind.mission.act("GoTo", goal=goal)
    plan = mind.start(leaf)
    mind.run()
    assert (leaf.status, leaf.name) == (Status.RUNNING, "GoTo goal")
    mind.until_done()
    assert (plan.status, plan.reason) == ("SUCCESS", "")
    assert leaf.replans == 0
    assert mind.rig.pose.distance(Pose2(2.0, 0.0)) < 0.06


def test_it_fails_with_the_actions_reason(mind, goal):
    leaf = mind.mission.act("GoTo", goal="gaol")
    plan = mind.start(leaf)
    mind.until_done()
    assert plan.status == "FAILURE"
    assert plan.reason.startswith("GoTo gaol: NO_GOAL: ")
    assert "Did you mean 'goal'" in plan.reason
    assert leaf.failure.reason is Reason.NO_GOAL


def test_after_a_reflex_it_stays_running_and_sends_the_action_again_from_where_the_robot_is(mind, goal):
    leaf = mind.mission.act("GoTo", goal=goal)
    plan = mind.start(leaf)
    mind.run(20)
    first = leaf.ticket
    mind.flinch(Flinch(speed=-0.3, distance=0.3))
    assert leaf.status is Status.RUNNING
    mind.run()
    assert (first.state, first.cancelled_by) == (TicketState.CANCELLED, "rules/Flinch")
    assert leaf.ticket is not first
    assert leaf.ticket.action is not first.action
    assert leaf.ticket.state is TicketState.RUNNING
    assert leaf.replans == 1
    assert [(e.node, e.count) for e in mind.rig.of(Replanned)] == [("GoTo goal", 1)]
    mind.until_done()
    assert plan.status == "SUCCESS"


def test_after_a_reflex_the_timers_go_on(mind):
    """A follower counts how long its leader has stood, flinching all the while."""
    graph = mind.rig.knowledge.graph
    graph.add("R2", "peer", tag=2)
    graph.set("R2", pose=Pose2(1.2, 0.0), speed=0.0, turn_rate=0.0)
    leaf = mind.mission.act("FollowRobot", leader="R2", rest=3.0, max_preemptions=100)
    plan = mind.start(leaf)
    while plan.status == "RUNNING" and mind.rig.clock.now() < 10.0:
        mind.run(10)
        mind.flinch(Flinch(speed=-0.05, distance=0.01))
    assert plan.status == "SUCCESS"
    assert leaf.replans >= 3
    assert 3.0 <= mind.rig.clock.now() < 4.2, "a reflex may be what is on when the three seconds are over"


def test_an_action_that_begins_anew_takes_over_nothing(mind):
    """Only what a reflex cut off is gone on with: a leaf that is halted and ticked again asks anew."""
    graph = mind.rig.knowledge.graph
    graph.add("R2", "peer", tag=2)
    graph.set("R2", pose=Pose2(1.2, 0.0), speed=0.0, turn_rate=0.0)
    leaf = mind.mission.act("FollowRobot", leader="R2", rest=3.0)
    plan = mind.start(leaf)
    mind.run(40)
    leaf.stop(Status.INVALID)
    mind.run(40)
    assert leaf.status is Status.RUNNING
    mind.until_done()
    assert plan.status == "SUCCESS"
    assert mind.rig.clock.now() == pytest.approx(5.0, abs=0.3)


def test_while_a_reflex_is_active_nothing_is_submitted(mind, goal):
    leaf = mind.mission.act("GoTo", goal=goal)
    mind.start(leaf)
    mind.run(20)
    mind.rig.pipeline.hold(True)
    mind.rig.submit(Flinch(speed=-0.3), by="rules/Flinch", priority=type(leaf.ticket.priority).HIGH)
    mind.run(40)
    assert mind.rig.pipeline.queued() == ()
    assert leaf.status is Status.RUNNING
    assert leaf.feedback_message == "GoTo waits for rules/Flinch"
    mind.rig.pipeline.hold(True, "rules/Blind")  # another rule took over
    mind.run(20)
    assert leaf.feedback_message == "GoTo waits for rules/Blind"
    assert mind.rig.wheels.speeds == [0.0, 0.0]


def test_a_halted_leaf_cancels_its_own_ticket_and_only_that(mind, goal):
    stop = mind.mission.when("front < 0.5 m")
    leaf = mind.mission.act("GoTo", goal=goal)
    other = mind.rig.submit(SetWheelSpeed(speeds=[0.1, 0.1], duration=500.0))
    mind.start(Selector("go", memory=False, children=[stop, leaf]))
    mind.run(5)
    assert leaf.ticket.state is TicketState.QUEUED
    mind.rig.knowledge.signals.write("front", [0.3], mind.rig.clock.now())
    mind.run(2)
    assert (leaf.ticket.state, leaf.ticket.cancelled_by) == (TicketState.CANCELLED, "go/GoTo goal")
    assert other.state is TicketState.RUNNING
    assert mind.plan.status == "SUCCESS"


def test_a_leaf_that_ended_long_ago_leaves_the_goal_to_who_pursues_it_now(mind, goal):
    leaf = mind.mission.act("GoTo", goal=goal)
    mind.start(leaf)
    mind.until_done()
    mind.rig.knowledge.world.pursue(goal)
    leaf.stop(Status.INVALID)
    assert mind.rig.knowledge.world.pursued() == goal


def test_it_fails_when_somebody_else_cancels_its_action(mind, goal):
    leaf = mind.mission.act("GoTo", goal=goal)
    plan = mind.start(leaf)
    mind.run(5)
    mind.rig.execute.stop("operator")
    mind.run(2)
    assert plan.reason == "GoTo goal: OTHER: GoTo was cancelled by operator"


def test_too_many_reflexes_without_progress_are_stuck_with_the_reflex_and_its_reading(mind, goal):
    leaf = mind.mission.act("GoTo", goal=goal, max_preemptions=3)
    plan = mind.start(leaf)
    for _ in range(4):
        mind.run(2)
        assert plan.status == "RUNNING"
        mind.flinch(Flinch(speed=-0.3, distance=0.05))
    mind.run(2)
    assert plan.status == "FAILURE"
    assert leaf.failure.reason is Reason.STUCK
    assert plan.reason == (
        "GoTo goal: STUCK: 4 pre-emptions without progress, the last by rules/Flinch (front = 0.21 m)"
    )
    assert mind.rig.knowledge.world.pursued() is None


def test_an_action_that_failed_during_a_reflex_does_not_wait_for_its_end(mind, goal):
    leaf = mind.mission.act("GoTo", goal=goal, max_preemptions=0)
    mind.start(leaf)
    mind.run(2)
    mind.rig.pipeline.hold(True)
    mind.rig.submit(Flinch(speed=-0.3), by="rules/Flinch", priority=type(leaf.ticket.priority).HIGH)
    assert mind.rig.pipeline.blocked
    mind.run(2)
    assert leaf.failure.reason is Reason.STUCK
    assert mind.rig.pipeline.held
    assert not mind.rig.pipeline.blocked


def test_reflexes_with_progress_in_between_are_not(mind, goal):
    leaf = mind.mission.act("GoTo", goal=goal, max_preemptions=3)
    plan = mind.start(leaf)
    for _ in range(8):
        mind.run(14)
        mind.flinch(Flinch(speed=-0.3, distance=0.02))
    assert leaf.replans >= 7
    mind.until_done()
    assert plan.status == "SUCCESS"


def test_to_and_fro_is_no_progress(mind, goal):
    """Nearer than at the last pre-emption is not enough: it must be nearer than ever."""
    leaf = mind.mission.act("GoTo", goal=goal, max_preemptions=4)
    plan = mind.start(leaf)
    for _ in range(12):
        mind.run(20)
        mind.rig.put(0.0, 0.0)
        mind.flinch(Flinch(speed=-0.3, distance=0.02))
    assert plan.status == "FAILURE"
    assert leaf.failure.reason is Reason.STUCK


def test_a_leaf_that_begins_anew_counts_anew(mind, goal):
    leaf = mind.mission.act("GoTo", goal=goal, max_preemptions=3)
    mind.start(leaf)
    for _ in range(5):
        mind.run(2)
        mind.flinch(Flinch(speed=-0.3, distance=0.02))
        mind.run(2)
        leaf.stop(Status.INVALID)
    assert leaf.failure is None
