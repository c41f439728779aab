"""RosAction and RosActionServer on a fake connection: goals, feedback, results, cancellation and what fails."""

import pytest

from rocs_bt.plan import TreePlan
from rocs_bt.ros2.ros_link import GoalState
from rocs_bt.trees.nodes import FAILURE, RUNNING, SUCCESS

from .ros_fake import Message, after


class TestAction:
    LINE = (
        '<RosAction action="fibonacci" type="test_msgs/action/Fibonacci" goal="order = {n}" '
        'feedback="sequence[0] -> {first}" result="sequence -> {all}" wait="1 s" timeout="5 s" {}/>'
    )

    def line(self, more=""):
        return self.LINE.replace("{}", more)

    def begun(self, grow, link, more=""):
        tree = grow(self.line(more), n=5)
        assert tree.tick() is RUNNING
        goal = link.goals[-1]
        goal.state = GoalState.ACCEPTED
        assert tree.tick() is RUNNING
        return tree, goal

    def test_goal_feedback_and_result(self, grow, link):
        tree, goal = self.begun(grow, link)
        assert goal.values == {"order": 5}
        goal.feedback, goal.feedback_count = Message({"sequence": [7, 8]}), 1
        assert tree.tick() is RUNNING
        assert tree.board["first"] == 7
        goal.state, goal.result = GoalState.SUCCEEDED, Message({"sequence": [1, 1, 2]})
        assert tree.tick() is SUCCESS
        assert tree.board["all"] == [1, 1, 2]
        assert (len(link.goals), goal.cancelled) == (1, 0)

    @pytest.mark.parametrize(
        ("state", "message"),
        [
            (GoalState.REJECTED, "REFUSED: the server of 'fibonacci' rejected the goal"),
            (GoalState.ABORTED, "REFUSED: the server of 'fibonacci' aborted the goal"),
            (GoalState.CANCELED, "REFUSED: the server of 'fibonacci' cancelled the goal"),
            (GoalState.FAILED, "REFUSED: 'fibonacci' failed: lost"),
        ],
    )
    def test_a_goal_that_does_not_succeed(self, grow, link, state, message):
        tree, goal = self.begun(grow, link)
        goal.state, goal.error = state, "lost"
        goal.result = None if state is GoalState.REJECTED else Message({"sequence": [1]})
        assert tree.tick() is FAILURE
        assert tree.root.feedback_message == message
        assert goal.cancelled == 0
        if state is GoalState.ABORTED:
            assert tree.board["all"] == [1], "a result is written also then"

    def test_a_halt_cancels_and_the_next_tick_sends_another_goal(self, grow, link):
        tree, goal = self.begun(grow, link)
        tree.halt()
        assert goal.cancelled == 1
        tree.board["n"] = 6
        assert tree.tick() is RUNNING
        assert link.goals[1].values == {"order": 6}
        link.goals[1].state = GoalState.SUCCEEDED
        tree.tick()
        tree.halt()
        assert link.goals[1].cancelled == 0

    def test_no_server_in_time(self, mind, grow, link):
        tree, link.here = grow(self.line(), n=5), False
        assert tree.tick() is RUNNING
        after(mind, 1.0)
        assert tree.tick() is FAILURE
        assert tree.root.feedback_message == "UNHEARD: no server of the action 'fibonacci' within 1 s"
        assert link.goals == []

    def test_a_goal_that_takes_too_long_and_a_server_that_is_lost(self, mind, grow, link):
        tree, goal = self.begun(grow, link)
        after(mind, 5.0)
        assert tree.tick() is FAILURE
        assert tree.root.feedback_message == "TIMEOUT: 'fibonacci' is not done after 5 s"
        assert goal.cancelled == 1
        tree.tick()
        link.here = False
        assert tree.tick() is FAILURE
        assert tree.root.feedback_message == "UNHEARD: the server of 'fibonacci' disappeared"

    def test_a_goal_that_is_never_acknowledged(self, mind, grow, link):
        tree = grow(self.line('server_timeout="2 s"'), n=5)
        assert tree.tick() is RUNNING
        after(mind, 1.9)
        assert tree.tick() is RUNNING
        after(mind, 0.1)
        assert tree.tick() is FAILURE
        wanted = "TIMEOUT: the server of 'fibonacci' has not acknowledged the goal within 2 s"
        assert tree.root.feedback_message == wanted
        assert link.goals[0].cancelled == 1

    @pytest.mark.parametrize(
        ("before", "then", "restarted"),
        [
            ({"1": "/r1/servers"}, {"1": "/r1/servers"}, False),
            ({"1": "/r1/servers"}, {"1": "/r1/servers", "2": "/r1/servers"}, True),  # the killed one is still listed
            ({"1": "/r1/servers"}, {"2": "/r1/servers"}, True),
            ({"1": "/r1/servers"}, {"2": "/r1/others"}, True),
            ({"1": "/r1/servers"}, {"2": ""}, True),
            ({"1": "/r1/servers"}, {"1": "/r1/servers", "2": "/r1/others"}, False),
            ({"1": "/r1/servers"}, {"1": "/r1/servers", "2": ""}, False),  # its name is not yet known
            ({"1": ""}, {"1": "/r1/servers"}, False),
            ({"1": ""}, {"1": "/r1/servers", "2": "/r1/servers"}, True),
            ({"1": "/r1/servers"}, {}, False),  # the connection does not tell
            ({}, {"1": "/r1/servers"}, False),
        ],
    )
    @pytest.mark.parametrize("acknowledged", [True, False])
    def test_a_server_that_is_restarted(self, mind, grow, link, before, then, restarted, acknowledged):
        link.servers = before
        tree, goal = self.begun(grow, link)
        goal.state = GoalState.ACCEPTED if acknowledged else GoalState.SENT
        link.servers = then
        after(mind, 1.0)
        assert tree.tick() is (FAILURE if restarted else RUNNING)
        if restarted:
            wanted = "UNHEARD: the server of 'fibonacci' was restarted, and has lost the goal"
            assert tree.root.feedback_message == wanted

    def test_a_server_that_does_not_match_is_named(self, mind, grow, link):
        tree, link.here = grow(self.line(), n=5), False
        link.mismatch = "the server in the node '/nav' has another type, test_msgs/action/Other"
        tree.tick()
        after(mind, 1.0)
        assert tree.tick() is FAILURE
        wanted = f"UNHEARD: no server of the action 'fibonacci' within 1 s: {link.mismatch}"
        assert tree.root.feedback_message == wanted

    def test_feedback_is_a_sign_of_life(self, mind, grow, link):
        tree, goal = self.begun(grow, link, 'feedback_timeout="1 s"')
        for count in (1, 2, 3):
            after(mind, 0.9)
            goal.feedback, goal.feedback_count = Message({"sequence": [1]}), count
            assert tree.tick() is RUNNING
        after(mind, 1.0)
        assert tree.tick() is FAILURE
        assert tree.root.feedback_message == "UNHEARD: no feedback of 'fibonacci' for 1 s"

    def test_a_reflex_cancels_it_and_it_is_sent_again(self, mind, grow, link):
        tree, goal = self.begun(grow, link, 'cancel_on_reflex="true"')
        mind.rig.pipeline.hold(True)
        assert tree.tick() is RUNNING
        assert tree.tick() is RUNNING
        assert goal.cancelled == 1
        goal.state = GoalState.CANCELED
        assert tree.tick() is RUNNING
        assert tree.tick() is RUNNING
        assert len(link.goals) == 1, "not while the reflex is active"
        mind.rig.pipeline.hold(False)
        assert tree.tick() is RUNNING
        assert [goal.values for goal in link.goals] == [{"order": 5}] * 2
        link.goals[1].state = GoalState.CANCELED
        assert tree.tick() is FAILURE, "by the server, not by a reflex"

    def test_without_that_a_reflex_does_not_matter(self, mind, grow, link):
        tree, goal = self.begun(grow, link)
        mind.rig.pipeline.hold(True)
        assert tree.tick() is RUNNING
        assert goal.cancelled == 0


class TestActionServer:
    class Asked:
        def __init__(self):
            self.request, self.cancel_requested = Message({"order": 3}), False
            self.fed, self.ended = [], None

        def feedback(self, values):
            self.fed.append(values)

        def end(self, state, result):
            self.ended = state, result

    def served(self, mind, child, **keys):
        inner = mind.mission.node(*child) if isinstance(child, tuple) else child
        root = mind.mission.node(
            "RosActionServer",
            inner,
            action="count",
            type="test_msgs/action/Fibonacci",
            goal="order -> {n}",
            feedback="sequence = {part}",
            result="sequence = {all}",
        )
        tree = TreePlan(root, mind.mission).tree
        for key, value in keys.items():
            tree.board[key] = value
        return tree

    def test_the_child_serves_the_goal(self, mind, link):
        child = mind.mission.node("Sequence", mind.mission.node("Sleep", msec="1000"))
        tree = self.served(mind, child)
        assert tree.tick() is RUNNING
        assert child.status is not RUNNING
        assert link.accepting
        link.asked = asked = self.Asked()
        assert tree.tick() is RUNNING
        assert tree.board["n"] == 3
        assert not link.accepting, "one goal at a time"
        tree.board["part"] = [1, 1]
        tree.tick()
        tree.tick()
        assert asked.fed == [{"sequence": [1, 1]}], "only when it changes"
        tree.board["all"] = [1, 1, 2]
        after(mind, 1.0)
        link.asked = None
        assert tree.tick() is SUCCESS
        assert asked.ended == (GoalState.SUCCEEDED, {"sequence": [1, 1, 2]})
        assert tree.tick() is RUNNING
        assert link.accepting

    def test_a_child_that_fails_aborts_the_goal(self, mind, link):
        tree = self.served(mind, ("AlwaysFailure",))
        link.asked = asked = self.Asked()
        assert tree.tick() is FAILURE
        assert asked.ended == (GoalState.ABORTED, {}), "a key without a value is omitted"

    @pytest.mark.parametrize("by", ["client", "halt"])
    def test_the_goal_ends_with_the_child_halted(self, mind, link, by):
        child = mind.mission.node("Sleep", msec="1000")
        tree = self.served(mind, child)
        link.asked = asked = self.Asked()
        assert tree.tick() is RUNNING
        if by == "client":
            asked.cancel_requested = True
            assert tree.tick() is FAILURE
            assert asked.ended == (GoalState.CANCELED, {})
        else:
            tree.halt()
            assert asked.ended == (GoalState.ABORTED, {})
            assert not link.accepting
        assert child.status is not RUNNING

    def test_a_result_that_does_not_fit_aborts(self, mind, link):
        tree = self.served(mind, ("AlwaysSuccess",), all="many")
        link.asked = asked = self.Asked()
        assert tree.tick() is FAILURE
        assert asked.ended == (GoalState.ABORTED, {})
        assert "sequence is an array" in tree.root.feedback_message
