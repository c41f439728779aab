"""SurroundMonitor: memory of echoes and of free ground."""

import math

import pytest

from rocs_bt.base.geometry import Pose2, Twist2, along_arc
from rocs_bt.control.arcs import BENDS


def test_what_a_reflex_drives_over_was_seen_lately(surround):
    rig = surround(max_free_ground_age=60.0, max_echo_age=1.0)
    rig.look_round(Pose2(0.0, 0.0, 0.0))

    def rear():
        rig.peer(Pose2(0.75, 0.0, math.pi))
        return rig.groups()["rear"]

    assert rear() > 0.2
    rig.wait(2.0)
    assert rear() < 0.2
    assert rig.room("room_behind")[2] > 0.4  # where a plan may send it


def test_it_tells_how_far_it_may_drive_on_ground_that_it_knows(rig):
    rig.groups()
    assert rig.room("room_behind") == [0.0] * 5
    rig.look_round(Pose2(0.0, 0.0, 0.0))
    assert all(0.5 < rig.room(name)[2] <= 1.0 for name in ("room_ahead", "room_behind"))
    rig.groups([math.inf, 0.5, math.inf])  # 0.45 m before the hull
    assert rig.room("room_ahead")[2] == pytest.approx(0.35, abs=0.11)
    assert rig.room("room_behind")[2] > 0.4
    rig.at(Pose2(0.0, 0.0, math.pi))
    rig.groups()
    # What it saw is behind it now, where it is sure of a square less.
    assert rig.room("room_behind")[2] == pytest.approx(0.25, abs=0.11)
    rig.at(Pose2(math.nan, 0.0, 0.0))
    rig.groups()
    assert rig.room("room_ahead") == [0.0] * 5


def test_it_turns_on_the_spot_only_where_all_that_its_corners_sweep_is_known_to_be_free(rig):
    rig.groups()
    assert rig.room("room_turned") == [0.0] * 12  # it has seen nothing beside it
    rig.look_round(Pose2(0.0, 0.0, 0.0))
    rig.groups()
    assert all(0.5 < room <= 1.0 for room in rig.room("room_turned"))
    rig.at(Pose2(0.0, 0.0, math.pi / 2.0))
    rig.groups([math.inf, 0.5, math.inf])  # 0.45 m before the hull, to the world's north
    north, others = rig.room("room_turned")[9], [rig.room("room_turned")[i] for i in (0, 3, 6)]
    assert north == pytest.approx(0.35, abs=0.11)
    assert min(others) > 0.5
    rig.at(Pose2(0.0, 0.0, 0.0))
    rig.groups()
    assert rig.room("room_turned")[9] == pytest.approx(north, abs=0.11)  # it remembers
    rig.at(Pose2(0.0, 0.36, 0.0))  # its flank is 0.14 m from what it saw, and a corner reaches 0.16 m beyond that
    rig.groups()
    assert rig.room("room_turned") == [0.0] * 12


def test_it_tells_how_far_it_may_turn_before_a_corner_comes_to_what_it_saw(surround):
    rig = surround(max_free_ground_age=20.0, max_echo_age=5.0)
    rig.groups()
    assert rig.room("free_turn") == [pytest.approx(math.pi)] * 2
    rig.at(Pose2(0.1, 0.0, 0.0))  # it looks again where it has moved
    rig.groups([math.inf, 0.5, math.inf])  # 0.45 m before the hull
    for after in (0.0, 10.0, 25.0):
        rig.wait(after - rig.clock.now())
        rig.at(Pose2(0.5, -0.25, math.pi / 2.0))  # at its right now: 0.1 m from the flank, before the middle
        rig.groups()
        left, right = rig.room("free_turn")
        assert (0.6 < left < 1.6) is (after < 20.0)  # the bow turns from it, and the stern comes round to it
        assert (right < 0.6) is (after < 20.0)
    rig.at(Pose2(math.nan, 0.0, 0.0))
    rig.groups()
    assert all(map(math.isnan, rig.room("free_turn")))


@pytest.mark.parametrize("bend", [1.5, -1.5])
def test_from_a_peer_it_goes_back_on_the_bend_on_which_it_came_where_straight_back_it_knows_nothing(rig, bend):
    for i in range(13):
        here = along_arc(Pose2(0.0, 0.0, 0.0), Twist2(0.1, 0.1 * bend), float(i))
        rig.at(here)
        rig.groups([0.2] * 3)  # in a fog: it knows of no more than where it has been
    rig.peer(Pose2(*here.transform(0.75, 0.0), here.yaw + math.pi), speed=0.1)
    found = rig.groups([0.2] * 3)
    back = rig.room("room_behind")
    assert back[2] < 0.2 < back[BENDS.index(bend)]
    assert found["front"] < 0.2 < found["rear"]
    assert rig.room("bend_off") == [0.0, bend]
    rig.peer(Pose2(5.0, 0.0, 0.0))
    rig.groups()
    assert rig.room("bend_off") == [0.0, 0.0]


def test_free_ground_is_forgotten_in_its_time(surround):
    rig = surround(max_free_ground_age=3.0, max_echo_age=1.0)
    rig.look_round(Pose2(0.0, 0.0, 0.0))
    rig.groups()
    assert rig.room("room_behind")[2] > 0.4
    for _ in range(70):
        rig.clock.advance()
    rig.peers(math.inf, math.inf)
    rig.at(Pose2(0.0, 0.0, 0.0))
    rig.groups()
    assert rig.room("room_behind") == [0.0] * 5


def test_where_a_peer_drove_nothing_stands(rig):
    rig.groups()
    assert rig.room("room_behind")[2] == 0.0
    for i, x in enumerate((-0.4, -0.6, -0.8)):
        for k, y in enumerate((-0.3, -0.1, 0.1, 0.3)):
            rig.at(Pose2(0.0, 0.0, 0.1 * ((i + k) % 2)))  # it looks again where it has turned
            rig.peer(Pose2(x, y))
            rig.groups()
    rig.at(Pose2(0.0, 0.0, 0.0))
    rig.groups()
    assert rig.room("room_behind")[2] > 0.3


def test_an_echo_is_remembered_beside_and_behind_until_it_is_seen_to_be_gone_or_is_old(rig):
    rig.groups([math.inf, 0.5, math.inf])  # 0.45 m before the hull
    rig.at(Pose2(0.0, 0.0, math.pi))
    assert rig.groups()["rear"] >= 0.27  # what stands comes no nearer to who does not drive back
    rig.at(Pose2(0.0, 0.0, math.pi), speed=-0.1)
    behind = rig.groups()
    assert behind["front"] == math.inf
    assert behind["rear"] == pytest.approx(0.45, abs=0.06)
    rig.at(Pose2(0.0, 0.0, 0.0))
    rig.groups()  # looks there, and nothing is there
    rig.at(Pose2(0.0, 0.0, math.pi), speed=-0.1)
    assert rig.groups()["rear"] == math.inf


def test_an_old_echo_is_forgotten(surround):
    rig = surround(max_echo_age=1.0)
    rig.groups([math.inf, 0.5, math.inf])
    for _ in range(25):
        rig.clock.advance()
    rig.peers(math.inf, math.inf)
    rig.at(Pose2(0.0, 0.0, math.pi))
    assert rig.groups()["rear"] == math.inf


def test_a_peers_echo_is_neither_counted_nor_remembered(rig):
    rig.peer(Pose2(1.15, 0.0))
    assert rig.groups([math.inf, 0.6, math.inf])["front"] == math.inf
    rig.peer(Pose2(-5.0, 0.0))
    rig.at(Pose2(0.0, 0.0, math.pi))
    assert rig.groups()["rear"] == math.inf
