"""The second run of Nav2's nodes that keep something: as that of a new node, after an end or a halt."""

import pytest

from rocs_bt.plan import mission_nodes
from rocs_bt.plan.nav2 import OWN
from rocs_bt.plan.nav2.run_aware import RunAware
from rocs_bt.trees.nodes import Leaf, Tree
from rocs_bt.trees.status import FAILURE, RUNNING, SUCCESS, outcome_name
from rocs_bt.trees.xml import load_xml

CASES = {
    "DistanceController": '<DistanceController distance="1">{}</DistanceController>',
    "DistanceTraveled": '<Inverter><DistanceTraveled distance="1"/></Inverter>',
    "GoalUpdated": "<Inverter><GoalUpdated/></Inverter>",
    "GoalUpdatedController": "<GoalUpdatedController>{}</GoalUpdatedController>",
    "PathLongerOnApproach": "<PathLongerOnApproach>{}</PathLongerOnApproach>",
    "RateController": '<RateController hz="3">{}</RateController>',
    "SingleTrigger": "<SingleTrigger>{}</SingleTrigger>",
    "SpeedController": '<SpeedController min_rate="3">{}</SpeedController>',
    "TimeExpired": '<Inverter><TimeExpired seconds="0.4"/></Inverter>',
}
PARENTS = ("Sequence", "ReactiveSequence", "PipelineSequence", "ReactiveFallback")


TICKED: list[str] = []
"""Names of the leaves that were ticked."""


class Letters(Leaf):
    """Returns one outcome per tick of a run, the last one for ever."""

    at = 0

    def initialise(self):
        self.at = 0

    def update(self):
        letter = "RRS"[min(self.at, 2)] if self.name == "after" else "RS"[min(self.at, 1)]
        self.at += 1
        TICKED.append(self.name)
        return {"R": RUNNING, "S": SUCCESS, "F": FAILURE}[letter]


def test_every_node_that_is_aware_of_runs_has_a_case():
    assert {node.tag for node in OWN if issubclass(node, RunAware)} == set(CASES)


@pytest.mark.parametrize("parent", PARENTS)
@pytest.mark.parametrize("tag", CASES)
@pytest.mark.parametrize("halted_after", [1, 2, 4, 0])
def test_the_second_run_is_that_of_a_new_node(mind, tag, parent, halted_after):
    nodes = mission_nodes(mind.rig.actions, [Letters], "nav2")
    body = CASES[tag].format('<Letters name="child"/>')
    body = f'<{parent}>{body}<Letters name="after"/></{parent}>'
    text = f'<root BTCPP_format="4"><BehaviorTree ID="M">{body}</BehaviorTree></root>'

    def new():
        return Tree(load_xml(text, nodes), clock=mind.rig.clock, owner=mind.mission)

    def run(tree, most):
        found = []
        for _ in range(most):
            TICKED.clear()
            found.append([outcome_name(tree.tick()), *TICKED])
            mind.rig.clock.advance(round(0.1 / mind.rig.clock.step))
            if found[-1][0] != "RUNNING":
                break
        return found

    tree = new()
    first = run(tree, halted_after or 12)
    if first[-1][0] == "RUNNING":
        tree.halt()
    assert run(tree, 12) == run(new(), 12)
