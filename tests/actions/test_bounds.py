"""Which numbers the parameters of actions may have: held where an action is made, and where it takes new ones."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocs_bt.actions import ACTIONS
from rocs_bt.base.errors import InputError
from rocs_bt.event import AtomicStarted
from rocs_bt.interfaces.action import InvalidAction, Reason, make_action, parameters_of
from rocs_bt.interfaces.pipeline import TicketState


@pytest.mark.parametrize(
    ("action", "parameters"),
    [
        ("Flinch", {"speed": -0.35}),
        ("Flinch", {"speed": 0.0}),
        ("AvoidCollision", {"turn": -1.0, "speed": -0.2}),
        ("SetWheelSpeed", {"speeds": [-0.1, 0.1], "duration": math.inf}),
        ("SetWheelSpeed", {"speeds": [0, 0], "duration": 0.0}),
        ("Stop", {"below": 0.0}),
        ("FollowPath", {"points": [(0, 0), (-1, 2)], "corner_radius": 0.0}),
    ],
)
def test_where_a_sign_or_no_end_makes_sense_it_is_free(action, parameters):
    assert make_action(ACTIONS, action, parameters).name == action


@pytest.mark.parametrize("name", ACTIONS)
def test_every_actions_defaults_lie_within_its_bounds(name):
    for parameter in parameters_of(ACTIONS[name]).values():
        assert parameter.required or parameter.default is None or not parameter.faults(parameter.default, name)


@given(st.floats(), st.floats())
def test_an_update_is_taken_whole_or_not_at_all(speed, timeout):
    action = make_action(ACTIONS, "Flinch", {"speed": -0.3})
    if math.isfinite(speed) and 0.0 < timeout < math.inf:
        action.update(speed=speed, timeout=timeout)
        assert (action.speed, action.timeout) == (speed, timeout)
    else:
        with pytest.raises(InputError, match="of Flinch must be"):
            action.update(speed=speed, timeout=timeout)
        assert (action.speed, action.timeout) == (-0.3, 1.5)


def test_what_cannot_be_made_fails_as_what_it_was_asked_for(rig):
    asked = {"speed": math.inf, "timeout": 2.0}
    with pytest.raises(InputError) as caught:
        make_action(ACTIONS, "Flinch", asked)
    ticket = rig.submit(InvalidAction("Flinch", asked, caught.value))
    ticket.action.update(speed=0.1)
    rig.run()
    assert ticket.state is TicketState.FAILED
    assert str(ticket.failure) == "CANNOT: speed of Flinch must be finite, found inf m/s."
    assert ticket.failure.reason is Reason.CANNOT
    (told,) = rig.of(AtomicStarted)
    assert (told.action, told.parameters) == ("Flinch", asked)
    assert rig.wheels.speeds == [0.0, 0.0]
