"""A recording gives back the very events that the blocks of a run emitted, whatever form they have in the file."""

import pytest

from rocs_bt import run
from rocs_bt.catalog import Catalog
from rocs_bt.event import ListSink
from rocs_bt.record import Recording


@pytest.mark.parametrize("scenario", ["exp1", "exp1_quadruped", "patrol_charge", "exp1_quadrotor"])
def test_what_was_emitted_is_read(scenario, tmp_path):
    sink = ListSink()
    run(scenario, Catalog(), duration=0.5, report=False, out=tmp_path / "run", sinks=[sink])
    read = list(Recording.open(tmp_path / "run").events())
    assert len(read) > 50
    assert read == sink.events
