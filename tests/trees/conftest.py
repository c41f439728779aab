"""A tree of scripted leaves, whose ticks are told as one line."""

import pytest

from .scripted import Bench


@pytest.fixture
def bench():
    return Bench()
