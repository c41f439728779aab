"""Decisive moments: the cause of a failure, else the first reflex."""

import pytest

from rocs_bt.event import (
    AgentStopped,
    ContactBegan,
    ContentRaised,
    NodeTicked,
    OutcomeDecided,
    RuleChanged,
    TicketChanged,
    TreeNode,
)
from rocs_bt.record import AgentInfo, RunHeader
from rocs_bt.record.explanation.decisive import decisive
from rocs_bt.record.fold.tracks import Tracks

LEAVES = ("root/look", "root/drive", "root/end")
NODES = (
    TreeNode(path="root", type="Fallback", children=LEAVES),
    *(TreeNode(path=path, type="Go") for path in LEAVES),
)


def ticked(t, node, text="", status="FAILURE"):
    return NodeTicked(t=t, agent="B", node=node, status=status, feedback=text)


def judged(outcome, t=2.0, agent="B"):
    return OutcomeDecided(t=t, agent=agent, outcome=outcome, reason="")


def fired(t, agent, rule="f/R"):
    return RuleChanged(t=t, agent=agent, rule=rule, phase="fired", priority=1)


def failing(count, action="Flinch", rule="f/R"):
    """An action of a rule that fails at 1.1 s, 1.2 s and so on."""
    about = {
        "agent": "B",
        "action": action,
        "priority": "HIGH",
        "state": "FAILED",
        "by": rule,
        "reason": "BLOCKED: wall",
    }
    return [TicketChanged(t=1.0 + 0.1 * i, ticket=i, **about) for i in range(1, count + 1)]


ENDED = RuleChanged(t=1.9, agent="B", rule="f/R", phase="ended", priority=1)
SILENT = [ticked(1.0, "root/drive", "no room"), ticked(1.0, "root/look", "dark"), ticked(2.0, "root/end")]
RAISED = ContentRaised(t=1.5, agent="B", kind="leaf", content="root/drive", file="a.py", line=3, detail="KeyError: 3")


@pytest.mark.parametrize(
    ("events", "outcomes", "expected"),
    [
        ([], {}, []),
        ([judged("success"), fired(1.0, "B"), fired(1.4, "A")], {}, [(1.0, "B|rule|f/R")]),
        ([fired(1.0, "B", "f/S"), fired(0.5, "A"), fired(1.4, "A")], {}, [(0.5, "A|rule|f/R")]),
        (
            [ticked(1.0, "root/drive", "no room"), ticked(1.0, "root"), judged("failed")],
            {},
            [(1.0, "B|node|root/drive")],
        ),
        ([*SILENT, ticked(2.0, "root"), judged("failed")], {}, [(1.0, "B|node|root/drive")]),
        ([*SILENT, ticked(2.0, "root"), judged("timeout")], {}, [(2.0, "B|node|root/end")]),
        ([RAISED, *SILENT, ticked(2.0, "root"), judged("failed")], {}, [(1.5, "B|node|root/drive")]),
        (
            [judged("stuck", agent="A", t=5.0), judged("timeout", t=3.0)],
            {},
            [(4.99, "A|outcome|"), (2.99, "B|outcome|")],
        ),
        (
            [
                ContactBegan(t=1.5, agent="B", other="box", kind="struck"),
                ContactBegan(t=2.5, agent="B", other="box", kind="collision"),
                judged("collision", t=20.0),
            ],
            {},
            [(2.49, "B|outcome|")],
        ),
        ([fired(1.0, "B"), *failing(5), judged("stuck")], {}, [(1.1, "B|rule|f/R")]),
        ([fired(1.0, "B"), *failing(5), judged("timeout")], {}, [(1.1, "B|rule|f/R")]),
        ([fired(1.0, "B"), *failing(2), judged("stuck")], {}, [(1.99, "B|outcome|")]),  # it happens
        ([fired(1.0, "B"), *failing(5), ENDED, judged("stuck")], {}, [(1.99, "B|outcome|")]),
        ([fired(1.0, "B"), *failing(5), fired(1.8, "B"), judged("stuck")], {}, [(1.99, "B|outcome|")]),  # anew
        ([fired(1.0, "B"), *failing(5), judged("collision")], {}, [(1.99, "B|outcome|")]),
        ([AgentStopped(t=4.0, agent="A", by="end")], {"A": "interrupted", "B": "success"}, [(3.99, "A|outcome|")]),
    ],
)
def test_the_cause_of_each_failure_is_first_and_else_the_first_reflex(events, outcomes, expected):
    agents = tuple(AgentInfo(name=name, robot="r", mission="m", nodes=NODES) for name in ("A", "B"))
    tracks = Tracks(RunHeader(scenario="s", seed=1, agents=agents))
    tracks.take(sorted(events, key=lambda event: event.t))
    assert [(round(each.t, 3), "|".join(each.about)) for each in decisive(tracks, outcomes)] == expected
