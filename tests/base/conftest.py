"""What the tests of the compiled kernel share."""

import pytest

import rocs_bt.geometry as geometry
from rocs_bt.compiled import PLAIN


@pytest.fixture(scope="session")
def kernel():
    """For tests that mean nothing where `_numbers.c` was not compiled."""
    if geometry.arc_positions is PLAIN["arc_positions"]:
        pytest.skip("there is no compiled kernel: Python itself runs here")
