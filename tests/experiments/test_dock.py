"""The scenario `dock`: nodes of our own on a simulated robot, from the plan of the way to the last centimetre."""

import math

import pytest

from rocs_bt import run
from rocs_bt.catalog import Catalog
from rocs_bt.event import Said, TicketChanged
from rocs_bt.record import Recording
from rocs_bt.running import replay


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    return run("dock", Catalog(), seed=1, out=tmp_path_factory.mktemp("run"), report=False)


def test_it_arrives_around_the_box_and_touches_nothing(result):
    told = result.summary.agents["R2"]
    assert told.outcome == "success"
    assert told.collisions == 0
    assert told.actions["Dock"] == {"SUCCEEDED": 1}
    assert told.path_length > math.hypot(1.0, 2.0) + 0.3, "a way around"


def test_what_it_says_is_in_the_recording(result):
    events = list(Recording.open(result.recording).events())
    first, second = (e for e in events if isinstance(e, Said))
    assert first.text.startswith("metres to the dock: 3.")
    assert (second.text, second.aloud) == ("docking", True)
    docked = [e for e in events if isinstance(e, TicketChanged) and e.action == "Dock"]
    assert docked[0].t >= second.t


def test_a_replay_decides_the_same(result):
    assert replay(Recording.open(result.recording), Catalog()) is None
