"""A project to edit."""

from __future__ import annotations

from pathlib import Path

import pytest

from rocs_bt.cli.main import call

MISSION = """<root BTCPP_format="4" main_tree_to_execute="Main">
  <!-- what to do -->
  <BehaviorTree ID="Main">
    <Sequence>
      %s
      <SubTree ID="Leg" place="gate"/>
    </Sequence>
  </BehaviorTree>
  <BehaviorTree ID="Leg">
    <GoTo goal="{place}"/>
  </BehaviorTree>
</root>
"""


@pytest.fixture(scope="session")
def made(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("edit") / "yard"
    assert call(["new", str(folder)]) == 0
    return folder


@pytest.fixture
def yard(made, monkeypatch) -> Path:
    """A project as `rocs-bt new` makes it, which tests do not change."""
    monkeypatch.chdir(made)
    return made
