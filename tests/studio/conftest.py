"""A live page that shows a run like EXP1, for all tests of this room."""

import pytest

from rocs_bt.studio.live import LivePage

from .. import synthetic


@pytest.fixture(scope="module")
def live():
    with LivePage() as page:
        page.begin(synthetic.header())
        yield page
