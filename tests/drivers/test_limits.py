"""How much a sensor may have: what no machine could carry is refused before anything is made of it."""

import pytest

from rocs_bt.drivers import DRIVER_PARAMETERS, read_parameters
from rocs_bt.errors import InputError

CONE = {"sites": ["s1", "s2"], "range": [0.0, 5.0]}


@pytest.mark.parametrize(
    ("driver", "given", "name", "message"),
    [
        ("range_cone", CONE, "rays", "sonar: rays must be 1 to 1000 for each beam, found {}."),
        ("robot_sensor", {"reach": 2.0}, "slots", "sonar: slots must be 1 to 1000, found {}."),
    ],
)
def test_a_count_has_a_least_and_a_greatest_value(driver, given, name, message):
    for count in (1, 1000):
        assert getattr(read_parameters(DRIVER_PARAMETERS[driver], {**given, name: count}, "sonar"), name) == count
    for count in (-1, 0, 1001, 100_000_000):
        with pytest.raises(InputError) as caught:
            read_parameters(DRIVER_PARAMETERS[driver], {**given, name: count}, "sonar")
        assert str(caught.value) == message.format(count)
