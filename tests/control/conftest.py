from __future__ import annotations

import pytest

from rocs_bt.control.locomotion import Locomotion
from rocs_bt.control.locomotion_kinds import differential_drive, mecanum_drive, omni3_drive, skid_drive

LIMITS = {"max_wheel_speed": 1.2, "max_wheel_acceleration": 1.5}
LOCOMOTIONS = {
    "differential": differential_drive(wheel_separation=0.33, **LIMITS),
    "skid": skid_drive(effective_wheel_separation=1.0, **LIMITS),
    "mecanum": mecanum_drive(half_length=0.22, half_width=0.2, **LIMITS),
    "omni3": omni3_drive(base_radius=0.2, **LIMITS),
}


@pytest.fixture
def drive() -> Locomotion:
    """A P3DX-like differential drive."""
    return LOCOMOTIONS["differential"]


@pytest.fixture(params=sorted(LOCOMOTIONS))
def any_drive(request: pytest.FixtureRequest) -> Locomotion:
    """Every kind of drive in turn."""
    return LOCOMOTIONS[request.param]
