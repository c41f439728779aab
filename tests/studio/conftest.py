"""A recorded run like EXP1, and a live page that shows it, for all tests of this room."""

import pytest

from rocs_bt.record.recorder import Recorder
from rocs_bt.record.recording import Recording
from rocs_bt.studio.live import LivePage

from .. import synthetic


@pytest.fixture(scope="session")
def recording(tmp_path_factory):
    recorder = Recorder(tmp_path_factory.mktemp("exp1") / "run.mcap", synthetic.header())
    for event in synthetic.events():
        recorder.emit(event)
    recorder.close(synthetic.summary())
    return Recording.open(recorder.path)


@pytest.fixture(scope="module")
def live():
    with LivePage() as page:
        page.begin(synthetic.header())
        yield page
