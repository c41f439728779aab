"""A mission that waits tells where, for what values and until when: in the recording and in the reason of a timeout."""

import pytest
from py_trees.behaviours import Running
from py_trees.decorators import Retry

from rocs_bt.event import NodeTicked
from rocs_bt.geometry import Pose2

RETRY = '<RetryUntilSuccessful num_attempts="-1">{}</RetryUntilSuccessful>'

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
