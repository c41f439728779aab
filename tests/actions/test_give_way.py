"""Where a robot that follows goes: on a string, or out of somebody's way."""

import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from rocs_bt.actions.give_way import GiveWay, braked_distance, trailer_path
from rocs_bt.actions.room import Room
from rocs_bt.base.geometry import Pose2
from rocs_bt.control.arcs import BENDS, HEADINGS

TIMES, AFAR = 0.1 * np.arange(26), 0.1 * np.arange(51)
HERE = Pose2(0.0, 0.0, 0.0)


def free(ahead=0.0, behind=0.0, turned=0.0):
    """So much room on each bend, and turned to each heading or to those of an array [m]."""
    return Room(np.full(len(BENDS), ahead), np.full(len(BENDS), behind), turned * np.ones(len(HEADINGS)))


OPEN = free(1.0, 1.0)


def leading(x, y, speed=0.0, yaw=0.0):
    """(51, 3) The same of a leader, which is looked at for longer."""
    return going(x, y, speed, yaw, AFAR)


def made(**given):
    return GiveWay(
        **{
            "length": 1.4,
            "room": 1.2,
            "half": (0.35, 0.28),
            "speed": 0.8,
            "braking": 0.75,
            "times": TIMES,
            "leader_times": AFAR,
            **given,
        }
    )


def going(x, y, speed=0.0, yaw=0.0, times=TIMES):
    """(26, 3) The way of somebody who keeps speed and heading."""
    run = speed * times
    return np.stack([x + run * math.cos(yaw), y + run * math.sin(yaw), np.full_like(run, yaw)], axis=1)


def test_a_taut_string_pulls_along_the_tractrix():
    leader = np.array([(1.2, 0.04 * i, 0.0) for i in range(100)])
    way = trailer_path(HERE, leader, 1.2, 1.0)
    for (x, y, yaw), place in zip(way[50:].tolist(), leader[50:].tolist(), strict=True):
        assert math.hypot(place[0] - x, place[1] - y) == pytest.approx(1.2)
        assert yaw == pytest.approx(math.atan2(place[1] - y, place[0] - x), abs=0.05)


def test_a_slack_string_does_nothing():
    way = trailer_path(Pose2(0.0, 0.0, 1.0), going(1.1, 0.0), 1.2, 0.06)
    assert way.tolist() == [[0.0, 0.0, 1.0]] * 26


def test_a_string_moves_nobody_faster_than_its_stride_and_ends_slack():
    way = trailer_path(HERE, going(3.0, 0.0, -0.1), 1.2, 0.06)
    steps = np.hypot(*np.diff(way[:, :2], axis=0).T)
    assert steps.max() <= 0.06 + 1e-9
    assert 3.0 - 0.25 - way[-1, 0] >= 1.2 - 0.25


def test_it_is_needed_only_where_somebody_comes_too_near():
    give_way, way = made(), going(0.0, 0.0)
    assert not give_way.needed(way, going(1.5, 0.0), [going(0.0, 1.5)])
    assert give_way.needed(way, going(1.5, 0.0, 0.4, math.pi), [])
    assert give_way.needed(way, going(1.5, 0.0), [going(0.0, 1.5, 0.3, -math.pi / 2.0)])


def test_it_goes_back_from_a_leader_that_comes_as_far_as_the_ground_is_free():
    leader = leading(1.3, 0.0, 0.3, math.pi)
    back = made().best(HERE, leader, [], OPEN)
    assert -1.0 <= back[-1, 0] < -0.3
    boxed = made().best(HERE, leader, [], free(behind=0.2))
    assert boxed[-1, 0] == pytest.approx(-0.2, abs=0.02)
    assert made().best(HERE, leader, [], free(ahead=1.0)).tolist() == [[0.0, 0.0, 0.0]] * 26


@pytest.mark.parametrize("heading", HEADINGS.tolist())
def test_boxed_in_it_turns_on_the_spot_to_where_the_ground_is_free(heading):
    room = free(turned=np.where(heading == HEADINGS, 1.0, 0.0))
    here = Pose2(0.0, 0.0, heading + math.pi / 2.0)
    leader = leading(-1.6 * math.cos(heading), -1.6 * math.sin(heading), 0.4, heading)
    way = made().best(here, leader, [], room)
    assert way[8, :2] == pytest.approx((0.0, 0.0))
    assert 0.3 < here.yaw - way[8, 2] < math.pi / 2.0  # on its way round, the short one
    assert math.hypot(*way[-1, :2]) > 0.3
    assert math.cos(math.atan2(way[-1, 1], way[-1, 0]) - heading) == pytest.approx(1.0)
    assert abs(math.cos(way[-1, 2] - heading)) == pytest.approx(1.0)
    assert np.array_equal(made().best(here, leader, [], free()), np.tile(here, (26, 1)))  # it does not turn, either


@pytest.mark.parametrize(("off", "stern"), [(60.0, False), (80.0, False), (100.0, True), (150.0, True), (-150.0, True)])
def test_it_turns_nose_or_stern_to_where_it_goes_whichever_is_nearer(off, stern):
    room = free(turned=np.where(HEADINGS[5] == HEADINGS, 1.0, 0.0))
    here, heading = Pose2(0.0, 0.0, HEADINGS[5] + math.radians(off)), float(HEADINGS[5])
    leader = leading(-1.6 * math.cos(heading), -1.6 * math.sin(heading), 0.4, heading)
    way = made().best(here, leader, [], room)
    assert math.cos(way[-1, 2] - heading) == pytest.approx(-1.0 if stern else 1.0)
    assert way[-1, :2] == pytest.approx(math.hypot(*way[-1, :2]) * np.array([math.cos(heading), math.sin(heading)]))
    assert abs(way[-1, 2] - here.yaw) <= math.pi / 2.0


def test_it_goes_aside_from_a_leader_that_will_not_stop_where_its_ground_ends():
    leader, aside = leading(1.5, 0.0, 0.4, math.pi), np.where(HEADINGS[3] == HEADINGS, 1.0, 0.0)  # to the right
    way = made().best(HERE, leader, [], free(behind=0.6, turned=aside))
    assert way[-1, 1] < -0.3
    shortsighted = made(leader_times=TIMES).best(HERE, leader[: len(TIMES)], [], free(behind=0.6, turned=aside))
    assert shortsighted[-1, :2] == pytest.approx((-0.6, 0.0))


def test_who_cannot_stay_may_come_nearer_to_its_leader_than_the_string_is_long_but_leaves_it_room():
    leader, room = leading(1.5, 0.0), free(ahead=0.25)
    comes = going(-0.3, 1.0, 0.2, -math.pi / 2.0)
    way = made().best(HERE, leader, [comes], room)
    assert way[-1, 0] == pytest.approx(0.25, abs=0.02)
    assert made().best(HERE, leader, [], room)[:, 0].max() < 0.1  # without need it does not


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_it_makes_room_for_who_comes_at_its_flank(side):
    other = going(0.1, side * 1.0, 0.2, -side * math.pi / 2.0)
    way = made().best(HERE, leading(1.4, 0.0), [other], OPEN)
    assert np.hypot(*(way[-1, :2] - other[-1, :2])) > np.hypot(*other[-1, :2]) + 0.2


def test_it_keeps_to_the_way_that_it_is_on_where_another_is_as_good():
    give_way = made()
    ways = [
        give_way.best(HERE, leading(1.4, 0.0), [going(0.0, y, 0.2, -math.copysign(math.pi / 2.0, y))], OPEN)
        for y in (0.9, 0.9001, 0.9)
    ]
    assert np.array_equal(ways[0], ways[1])
    assert np.array_equal(ways[0], ways[2])


@given(
    st.floats(0.85, 2.5),
    st.floats(-math.pi, math.pi),
    st.floats(0.0, 0.4),
    st.floats(-math.pi, math.pi),
    st.floats(0.6, 2.0),
    st.floats(-math.pi, math.pi),
    st.floats(0.0, 1.0),
    st.floats(0.0, 1.0),
    st.floats(0.0, 1.0),
)
def test_it_never_crowds_its_leader_and_keeps_to_free_ground(
    away, at, speed, heading, other, where, ahead, behind, turned
):
    leader = leading(away * math.cos(at), away * math.sin(at), speed, heading)
    others = [going(other * math.cos(where), other * math.sin(where))]
    way = made().best(HERE, leader, others, free(ahead, behind, turned))
    apart = np.hypot(*(way - leader[: len(way)])[:, :2].T).min()
    standing = np.hypot(leader[: len(way), 0], leader[: len(way), 1]).min()
    assert apart >= min(1.2, standing - 0.02) - 1e-9
    run = np.hypot(*np.diff(way[:, :2], axis=0).T).sum()
    assert run <= max(ahead, behind, turned) + 1e-9
    assert np.hypot(*np.diff(way[:, :2], axis=0).T).max() <= 0.08 + 1e-9


@example(speed=1.0, reach=0.09917591800522255, braking=0.203125)  # what is left to cruise rounds below 0
@given(speed=st.floats(0.0, 1.5), reach=st.floats(0.0, 1.0), braking=st.floats(0.2, 3.0))
def test_who_goes_as_far_as_the_ground_is_free_can_stand_there(speed, reach, braking):
    gone = braked_distance(speed, np.array([[reach]]), AFAR, braking)[0]
    fast = np.diff(gone) / 0.1
    assert gone[0] == 0.0
    assert (gone <= reach + 1e-9).all()
    assert (fast >= -1e-9).all()
    assert (fast <= speed + 1e-9).all()
    assert (np.diff(fast) >= -braking * 0.1 - 1e-6).all()
    assert (np.square(fast) <= 2.0 * braking * (reach - gone[:-1]) + 1e-9).all()
    if speed > 0.0 and reach / speed + speed / braking < AFAR[-1]:
        assert gone[-1] == pytest.approx(reach, abs=1e-6)


@pytest.mark.parametrize(
    ("leader", "room"),
    [
        (leading(1.3, 0.0, 0.4, math.pi), free(behind=0.5)),  # straight back before one that comes
        (leading(1.0, 0.0), free(turned=0.5)),  # and turned on the spot first, where that alone is free
    ],
)
def test_the_way_slows_down_before_the_free_ground_ends(leader, room):
    way = made().best(HERE, leader, [], room)
    fast = np.hypot(*np.diff(way[:, :2], axis=0).T) / 0.1
    left = 0.5 - np.hypot(way[:-1, 0], way[:-1, 1])
    assert fast.max() > 0.4
    assert (np.square(fast) <= 2.0 * 0.75 * left + 1e-6).all()
    hasty = made(braking=1e6).best(HERE, leader, [], room)
    assert np.hypot(*np.diff(hasty[:, :2], axis=0).T).max() / 0.1 > fast.max() - 1e-9
    assert (
        np.square(np.hypot(*np.diff(hasty[:, :2], axis=0).T) / 0.1)
        > 2.0 * 0.75 * (0.5 - np.hypot(*hasty[:-1, :2].T)) + 1e-6
    ).any()
