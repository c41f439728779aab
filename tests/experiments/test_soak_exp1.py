"""EXP1 over two hundred seeds, at both control rates; the figures are in the test's output (`make soak`)."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parent


@pytest.mark.soak
@pytest.mark.parametrize("control", [20, 50])
def test_exp1_over_two_hundred_seeds(control: int) -> None:
    command = [sys.executable, str(HERE / "campaign.py"), "exp1", "--control", str(control), "--json"]
    found = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    print(json.dumps(found, indent=1))
    mind = found["agents"]["R2"]
    assert mind["success"]["of"] == 200
    assert mind["success"]["count"] >= 194
    assert not [what for what in mind["touches"] if not what.endswith("R1")]
    assert mind["both_routes"] >= 180
