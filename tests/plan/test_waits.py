"""A mission that waits tells where, for what values and until when: in the recording and in the reason of a timeout."""

import pytest
from py_trees.behaviours import Running
from py_trees.decorators import Retry

from rocs_bt.base.geometry import Pose2
from rocs_bt.catalog import Catalog
from rocs_bt.event import NodeTicked
from rocs_bt.nav2.nodes import OWN
from rocs_bt.ros2.nodes import NAV2_SERVERS, ROS_NODES
from rocs_bt.trees.nodes import BUILTIN, Instant, Node

from .ros_fake import Link

GONE = '<GoTo goal="nowhere"/>'
RETRY = '<RetryUntilSuccessful num_attempts="-1">{}</RetryUntilSuccessful>'

WAITING = '<PipelineSequence>{}<AlwaysSuccess/>{}<Sleep msec="60000"/></PipelineSequence>'

CASES = [  # body of the tree, the leaf in which it waits, what it waits for
    ('<Sleep name="rest" msec="60000"/>', "rest", "until 60.00 s"),
    ('<Delay name="late" delay_msec="60000"><AlwaysSuccess/></Delay>', "late", "until 60.00 s"),
    ('<TestNode name="test" async_delay="60000"/>', "test", "until 60.00 s"),
    (
        RETRY.format('<ScriptCondition name="enough" code="battery &gt; 0.9"/>'),
        "enough",
        "battery > 0.9, battery = 0.41",
    ),
    (
        '<Precondition name="enough" if="battery &gt; 0.9" else="RUNNING"><AlwaysSuccess/></Precondition>',
        "enough",
        "battery > 0.9, battery = 0.41",
    ),
    (
        f'<WaitValueUpdate name="news" entry="{{battery}}">{RETRY.format("<AlwaysFailure/>")}</WaitValueUpdate>',
        "AlwaysFailure",
        "",
    ),
    ('<WaitValueUpdate name="news" entry="{other}"><AlwaysSuccess/></WaitValueUpdate>', "news", "for a new value of"),
    (f'<Timeout name="in time" msec="60000">{RETRY.format("<AlwaysFailure/>")}</Timeout>', "", "until 60.00 s"),
    ('<Timeout name="in time" msec="60000"><Sleep msec="90000"/></Timeout>', "Sleep", "until 90.00 s; until 60.00 s"),
    (
        RETRY.format('<Sequence><AlwaysSuccess/><ScriptCondition name="no" code="battery == 1"/></Sequence>'),
        "no",
        "0.41",
    ),
    (
        RETRY.format('<Fallback><AlwaysFailure/><ScriptCondition name="no" code="battery == 1"/></Fallback>'),
        "no",
        "0.41",
    ),
    ('<Parallel><Sleep name="a" msec="60000"/><Sleep name="b" msec="90000"/></Parallel>', "a", "90.00 s"),
]
NAV2 = [
    (WAITING.format('<RateController hz="0.1">', "</RateController>"), "ticks its child again at 10.00 s"),
    (WAITING.format('<DistanceController distance="2">', "</DistanceController>"), "after 2 m, moved 0.0 m"),
    (WAITING.format('<SpeedController min_rate="0.1">', "</SpeedController>"), "ticks its child again at 10.0 s"),
    (WAITING.format("<GoalUpdatedController>", "</GoalUpdatedController>"), "ticks its child again with a new goal"),
    (RETRY.format('<TimeExpired name="no" seconds="60"/>'), "until 60."),
    (RETRY.format('<DistanceTraveled name="no" distance="2"/>'), "moved 0.0 m of 2 m"),
    ('<AssistedTeleop time_allowance="60"/>', "until 60.00 s"),
]
ROS = [
    ('<RosSubscribe topic="a" type="std_msgs/msg/String" timeout="60 s"/>', "waits for 'a': no message, until 60.00 s"),
    ('<RosService service="a" type="std_srvs/srv/SetBool" wait="60 s"/>', "waits for a server of 'a', until 60.00 s"),
    ('<RosAction action="a" type="nav2_msgs/action/Spin" wait="60 s"/>', "waits for a server of 'a', until 60.00 s"),
    ('<RosActionServer action="a" type="nav2_msgs/action/Spin"><AlwaysSuccess/></RosActionServer>', "a goal of 'a'"),
]


@pytest.mark.parametrize(("body", "leaf", "waits"), CASES)
def test_the_reason_of_a_timeout_names_the_leaf_that_waits_its_values_and_its_deadline(mind, body, leaf, waits):
    document = (
        f'<root BTCPP_format="4"><BehaviorTree ID="main"><Sequence><Script code="battery := 0.41"/>{body}</Sequence>'
        "</BehaviorTree></root>"
    )
    plan = mind.start(mind.mission.tree(document))
    mind.run(40)
    assert plan.status == "RUNNING"
    assert f"{leaf}' has waited for 1.9" in plan.running or f"{leaf}' has waited for 2.0" in plan.running
    assert waits in plan.running
    told = [e.feedback for e in mind.rig.of(NodeTicked)]
    assert all(any(part in text for text in told) for part in waits.split("; "))


def waiting(mind, body, dialect=""):
    """What a plan is doing after half a second."""
    mind.mission.dialect = dialect
    document = f'<root BTCPP_format="4"><BehaviorTree ID="main">{body}</BehaviorTree></root>'
    plan = mind.start(mind.mission.tree(document))
    mind.run(10)
    assert plan.status == "RUNNING"
    return plan.running


@pytest.mark.parametrize(("body", "waits"), NAV2)
def test_nodes_of_nav2_tell_what_they_wait_for(mind, body, waits):
    assert waits in waiting(mind, body, "nav2")


@pytest.mark.parametrize(("body", "waits"), ROS)
def test_nodes_for_ros_tell_what_they_wait_for_and_until_when(mind, body, waits):
    mind.mission.services = {"ros2": Link()}
    mind.mission.services["ros2"].here = False
    assert waits in waiting(mind, body)


SLOW = '<Sequence><Sleep msec="100"/>{}</Sequence>'
COUNTED = [
    ('<RetryUntilSuccessful name="n" num_attempts="3">', "AlwaysFailure", ["1/3", "2/3", "3/3", "3/3 failed"]),
    ('<RetryUntilSuccessful name="n" num_attempts="3">', "AlwaysSuccess", ["1/3", ""]),
    ('<RetryUntilSuccessful name="n" num_attempts="-1">', "AlwaysFailure", [""]),
    ('<Repeat name="n" num_cycles="2">', "AlwaysSuccess", ["1/2", "2/2", ""]),
    ('<Repeat name="n" num_cycles="2">', "AlwaysFailure", ["1/2", "1/2 failed"]),
]


@pytest.mark.parametrize(("tag", "leaf", "said"), COUNTED)
def test_nodes_that_count_tell_the_attempt_of_how_many(mind, tag, leaf, said):
    body = f"{tag}{SLOW.format(f'<{leaf}/>')}</{tag[1 : tag.index(' ')]}>"
    mind.start(mind.mission.tree(f'<root BTCPP_format="4"><BehaviorTree ID="main">{body}</BehaviorTree></root>'))
    mind.run(30)
    word = "attempt" if "Retry" in tag else "cycle"
    notes = [e.feedback for e in mind.rig.of(NodeTicked) if e.node.rpartition("/")[2] == "n"]
    assert notes == [text and f"{word} {text}" for text in said]


def test_a_recovery_tells_the_attempt_and_the_recovery(mind):
    mind.mission.dialect = "nav2"
    parts = SLOW.format("<AlwaysFailure/>") + SLOW.format("<AlwaysSuccess/>")
    body = f'<RecoveryNode name="n" number_of_retries="1">{parts}</RecoveryNode>'
    mind.start(mind.mission.tree(f'<root BTCPP_format="4"><BehaviorTree ID="main">{body}</BehaviorTree></root>'))
    mind.run(30)
    notes = [e.feedback for e in mind.rig.of(NodeTicked) if e.node.rpartition("/")[2] == "n"]
    assert notes == ["attempt 1/2", "recovery 1/1", "attempt 2/2", "attempt 2/2 failed"]


def test_a_follower_tells_that_it_waits_for_its_leader(mind):
    mind.rig.knowledge.graph.add("R2", "peer", pose=Pose2(3.0, 0.0))
    plan = mind.start(mind.mission.act("FollowRobot", leader="R2", rest="5 s"))
    mind.run(10)
    assert "and waits until its leader R2 has been stationary for 5 s (it last moved at" in plan.running


def test_each_leaf_that_can_be_running_tells_what_it_waits_for():
    nodes = [*BUILTIN.values(), *OWN, *NAV2_SERVERS, *ROS_NODES, *Catalog().load_nodes()]
    leaves = [node for node in nodes if node.max_children == 0 and not issubclass(node, Instant)]
    assert not {node.tag for node in leaves if node.wait_text is Node.wait_text}


def test_the_values_in_the_recording_are_those_of_each_tick(mind):
    signals, clock = mind.rig.knowledge.signals, mind.rig.clock
    condition = mind.mission.when("front > 2 m")
    plan = mind.start(Retry("retry", condition, num_failures=100))
    for k in range(20):
        signals.write("front", [1.0 + 0.01 * (k // 4)], clock.now())
        mind.run(2)
    told = [e.feedback for e in mind.rig.of(NodeTicked) if e.node.endswith(condition.name)]
    assert told == [f"front > 2 m, front = {1.0 + 0.01 * k:.3g} m" for k in range(5)]
    assert told[-1] in plan.running


def test_an_action_that_a_reflex_interrupted_is_told_to_wait_for_it(mind):
    mind.rig.knowledge.world.place("goal", Pose2(3.0, 0.0), kind="goal")
    plan = mind.start(mind.mission.act("GoTo", goal="goal"))
    mind.run(10)
    assert plan.running == "GoTo(goal) has run for 0.5 s"
    mind.flinch(mind.rig.actions["Flinch"](speed=-0.2, distance=0.1))
    told = [e.feedback for e in mind.rig.of(NodeTicked)]
    assert "GoTo waits for rules/Flinch" in told


def test_a_leaf_that_cannot_tell_is_still_named(mind):
    plan = mind.start(Running("odd"))
    mind.run(10)
    assert plan.running == "'odd' has waited for 0.5 s: running"


@pytest.mark.parametrize(
    ("line", "reason"),
    [
        (
            f'<Fallback>{GONE}<AlwaysFailure name="end"/></Fallback>',
            "Fallback/end: FAILURE; the last failure with a reason: ",
        ),
        (f'<Fallback><AlwaysFailure name="end"/>{GONE}</Fallback>', ""),
        ('<Fallback><AlwaysFailure/><AlwaysFailure name="end"/></Fallback>', "Fallback/end: FAILURE"),
    ],
)
def test_a_mission_whose_last_leaf_says_nothing_names_the_last_one_that_did(mind, grow, line, reason):
    mind.start(grow(line).root)
    mind.until_done()
    said = "Fallback/GoTo: NO_GOAL: no node 'nowhere'"
    wanted = reason + said if not reason.endswith("FAILURE") else reason
    assert mind.plan.reason.startswith(wanted), mind.plan.reason
