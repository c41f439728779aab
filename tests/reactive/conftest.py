"""What the tests of rules share."""

import pytest

from . import random_rules as module


@pytest.fixture(scope="session")
def random_rules():
    """The module of random rule sets and traces."""
    return module
