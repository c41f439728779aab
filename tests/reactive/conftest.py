"""What the tests of rules share."""

import importlib.util
import sys
from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def random_rules():
    """The module of random rule sets and traces."""
    file = Path(__file__).with_name("random_rules.py")
    spec = importlib.util.spec_from_file_location("random_rules", file)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses look themselves up
    spec.loader.exec_module(module)
    return module
