"""A command beyond the limits, seen as a user sees it: in the summary, the report and `--why`."""

import pytest
from py_trees.behaviour import Behaviour

import rocs_bt
from rocs_bt.catalog import Catalog
from rocs_bt.event import BodyMoved, CommandLimited, ListSink, unpack
from rocs_bt.record import Recording, explain

from ..pages import data_of


class Rush(rocs_bt.AtomicAction):
    """Command 5 m/s, whatever the wheels can."""

    def act(self, body):
        body.motion.command([5.0, 5.0])
        return rocs_bt.Progress.RUNNING


def build(mission) -> Behaviour:
    return mission.act("Rush")


@pytest.fixture(scope="module")
def rushed(tmp_path_factory):
    out, sink = tmp_path_factory.mktemp("rushed"), ListSink()
    return rocs_bt.run("exp1", Catalog(), out=out, duration=1.0, missions={"R2": build}, sinks=[sink]), sink


def test_an_action_of_a_users_own_cannot_exceed_the_wheels_limits(rushed):
    events = rushed[1].events
    limited = [e for e in events if isinstance(e, CommandLimited)]
    assert {(e.wanted, e.given, e.action) for e in limited} == {((5.0, 5.0), (1.2, 1.2), "Rush")}
    fastest = max(max(unpack(e.wheels), default=0.0) for e in events if isinstance(e, BodyMoved) and e.body == "R2")
    assert 0.5 < fastest < 1.2 * 1.01


def test_it_is_counted_in_summary_and_report_and_shown_by_why(rushed):
    result, sink = rushed
    count = len([e for e in sink.events if isinstance(e, CommandLimited)])
    assert result.summary.agents["R2"].commands_limited == {"Rush": count}
    numbers = dict(data_of(result.report)["results"]["R2"]["numbers"])
    assert numbers["commands limited by the safety gate"] == str(count)
    why = explain(Recording.open(result.recording), 0.05).text(everything=True)
    assert "limited by the safety gate: Rush wanted [5, 5]" in why
    assert "wheels = [1.2, 1.2]" in why
