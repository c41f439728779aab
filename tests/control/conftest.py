from __future__ import annotations

import pytest

from rocs_bt.control.locomotion import Locomotion
from rocs_bt.control.locomotion_kinds import make_locomotion

LIMITS = {"max_wheel_speed": 1.2, "max_wheel_acceleration": 1.5}
LOCOMOTIONS = {
    "differential": make_locomotion("differential", wheel_separation=0.33, **LIMITS),
    "skid": make_locomotion("skid", effective_wheel_separation=1.0, **LIMITS),
    "mecanum": make_locomotion("mecanum", half_length=0.22, half_width=0.2, **LIMITS),
    "omni3": make_locomotion("omni3", base_radius=0.2, **LIMITS),
}


@pytest.fixture
def drive() -> Locomotion:
    """A P3DX-like differential drive."""
    return LOCOMOTIONS["differential"]


@pytest.fixture(params=sorted(LOCOMOTIONS))
def any_drive(request: pytest.FixtureRequest) -> Locomotion:
    """Every kind of drive in turn."""
    return LOCOMOTIONS[request.param]
