"""SurroundMonitor: values of the standard groups for known peers, and escapes from them."""

import math

import pytest

from rocs_bt.base.errors import InputError
from rocs_bt.base.geometry import Pose2
from rocs_bt.monitor.range_monitor import GroupTable

from .summit_xl import encounter, surround_monitor

DUTY, SURE, GROUPS = encounter.DUTY, encounter.SURE, surround_monitor.GROUPS


def test_without_peers_and_echoes_the_groups_say_nothing(rig):
    assert set(rig.groups().values()) == {math.inf}
    assert [rig.knowledge.signals.spec(name).size for name in GROUPS] == [5, 3, 3, 3]


def test_beams_count_as_in_any_range_monitor(rig):
    rig.groups([0.9, 0.5, 0.8])
    read = {name: rig.knowledge.signals.read(name, 0.0).tolist() for name in GROUPS}
    assert read["front"][:3] == [0.9, 0.5, 0.8]
    assert (read["left_gap"][0], read["right_gap"][0], read["rear"][0]) == (0.9, 0.8, math.inf)


@pytest.mark.parametrize(("y", "side"), [(1.0, "left_gap"), (-1.0, "right_gap")])
def test_a_peer_that_stands_beside_is_as_far_as_the_hulls_are_apart(rig, y, side):
    rig.peer(Pose2(0.1, y))
    found = rig.groups()
    assert found[side] == pytest.approx(1.0 - 0.3 - 0.25)
    assert found["front"] == found["rear"] == math.inf


def test_a_peer_that_comes_counts_as_nearer_and_one_that_goes_as_it_is(rig):
    rig.peer(Pose2(0.1, 1.3, -math.pi / 2.0), speed=0.3)
    coming = rig.groups()["left_gap"]
    rig.peer(Pose2(0.1, 1.3, math.pi / 2.0), speed=0.3)
    assert coming == pytest.approx(0.75 - 0.3 * 0.7, abs=0.02)
    assert rig.groups()["left_gap"] == pytest.approx(0.75, abs=0.02)


def test_from_a_peer_that_comes_from_behind_it_is_driven_ahead(rig):
    rig.look_round(Pose2(0.0, 0.0, 0.0))
    rig.peer(Pose2(-0.95, 0.0, 0.0), speed=0.3)
    found = rig.groups()
    assert found["rear"] < 0.2
    assert found["front"] == math.inf


def test_from_a_peer_that_comes_ahead_it_is_driven_back_only_over_ground_that_is_free(rig):
    rig.peer(Pose2(0.95, 0.0, math.pi), speed=0.3)
    unknown = rig.groups()
    assert max(unknown["front"], unknown["rear"]) < 0.2  # nobody knows what is behind: it stands
    for x in (-0.8, -0.6, -0.4, -0.2, 0.0):
        rig.at(Pose2(x, 0.0, 0.0))
        rig.peer(Pose2(5.0, 0.0))
        rig.groups()
    rig.peer(Pose2(0.95, 0.0, math.pi), speed=0.3)
    known = rig.groups()
    assert known["front"] < 0.2
    assert known["rear"] > 0.25


def test_it_keeps_to_its_way_off_for_a_while(surround):
    begun, fresh = surround(), surround()
    for rig in (begun, fresh):
        rig.look_round(Pose2(0.0, 0.0, 0.0))
    begun.peer(Pose2(-0.95, 0.0, 0.0), speed=0.3)
    assert begun.groups()["front"] == math.inf
    for rig in (begun, fresh):
        rig.peer(Pose2(-0.58, 0.0, 0.0))  # all but touching
    assert begun.groups()["front"] == math.inf
    assert fresh.groups()["front"] < 0.2  # who has not begun to go stands
    begun.peer(Pose2(0.65, -0.35, math.pi / 2.0), speed=0.4, name="R4")  # who crosses the way
    assert begun.groups()["front"] < 0.2
    begun.peer(Pose2(5.0, 0.0, 0.0), name="R4")
    begun.peer(Pose2(-0.95, 0.0, 0.0), speed=0.3)
    assert begun.groups()["front"] == math.inf
    begun.peer(Pose2(-0.58, 0.0, 0.0))
    begun.wait(1.2)
    assert begun.groups()["front"] < 0.2


def test_from_who_would_hit_it_it_goes_while_it_can(rig):
    rig.look_round(Pose2(0.0, 0.0, 0.0))
    rig.peer(Pose2(-0.63, 0.1, 0.0), speed=0.2)  # 3 cm behind the hull: standing it would be hit
    found = rig.groups()
    assert found["rear"] < 0.2
    assert found["front"] == math.inf


def test_who_is_pinned_goes_wherever_it_comes_no_nearer_after_a_while(rig):
    rig.look_round(Pose2(0.0, 0.0, 0.0))
    rig.peer(Pose2(-0.58, 0.0, 0.0))
    assert rig.groups()["front"] < 0.2
    for _ in range(4):
        rig.wait(1.0)
        assert rig.groups()["front"] < 0.2
    rig.wait(1.2)
    assert rig.groups()["front"] == math.inf


def test_it_stands_in_time_before_a_leader_that_comes(rig):
    rig.knowledge.graph.add("R2", "peer", tag=2)
    rig.knowledge.graph.relate("R3", "follows", "R2", distance=1.4, safety=0.8)
    standing = {}
    for speed in (0.0, 0.4):
        rig.at(Pose2(0.0, 0.0, 0.0), speed=0.6)
        rig.peer(Pose2(1.15, 0.0, math.pi), speed=speed, name="R2")
        found = rig.groups()
        standing[speed] = max(found["front"], found["rear"]) < 0.2
    assert standing == {0.0: False, 0.4: True}


def test_from_a_peer_that_comes_at_its_flank_it_does_not_get_away_and_stands(rig):
    rig.peer(Pose2(0.0, 0.72, -math.pi / 2.0), speed=0.3)
    found = rig.groups()
    assert max(found["front"], found["rear"]) < 0.2


def test_what_the_corner_of_a_turning_hull_would_sweep_is_near(rig):
    rig.peer(Pose2(0.33, 0.80))
    still = rig.groups()["left_gap"]
    rig.at(Pose2(0.0, 0.0, 0.0), turn=1.5)
    turning = rig.groups()
    assert min(turning.values()) < still - 0.05


def test_it_stands_within_the_safety_distance_of_whom_it_follows_and_a_while_after(rig):
    rig.peer(Pose2(1.05, 0.0), name="R2")
    rig.knowledge.graph.relate("R3", "follows", "R2", distance=1.4, safety=0.9)
    assert min(rig.groups().values()) > 0.2
    rig.knowledge.graph.unrelate("R3", "follows", "R2")
    rig.knowledge.graph.relate("R3", "follows", "R2", distance=1.4, safety=1.0)
    standing = rig.groups()
    assert max(standing["front"], standing["rear"]) < 0.2
    rig.knowledge.graph.unrelate("R3", "follows", "R2")  # as a reflex does that interrupts the following
    assert max(rig.groups()[name] for name in ("front", "rear")) < 0.2
    for later, stands in ((DUTY - 5.0, True), (10.0, False)):
        rig.wait(later)
        rig.peer(Pose2(1.05, 0.0), name="R2")
        assert bool(rig.groups()["front"] < 0.2) is stands


@pytest.mark.parametrize(("beyond", "stands"), [(-0.01, True), (0.01, False)])
def test_it_keeps_a_little_more_than_the_safety_distance_for_it_only_estimates_its_leader(rig, beyond, stands):
    rig.peer(Pose2(1.2, 0.0), name="R2")
    rig.knowledge.graph.relate("R3", "follows", "R2", distance=1.4, safety=1.2 - SURE - beyond)
    assert bool(rig.groups()["front"] < 0.2) is stands


def test_without_its_pose_or_its_robot_sensor_nothing_is_known(rig):
    rig.peers(math.nan, math.inf)
    assert all(map(math.isnan, rig.groups().values()))
    rig.peers(math.inf, math.inf)
    rig.at(Pose2(math.nan, 0.0, 0.0))
    assert all(map(math.isnan, rig.groups().values()))


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"max_free_ground_age": 5.0}, "at least max_echo_age, found 5 s and 10 s"),
        ({"mounts": [(0.0, 0.0, 0.0)]}, "x, y and yaw of 3 beams"),
        ({"group": {"front": GroupTable(beams=(0,))}}, "left_gap"),
    ],
)
def test_what_it_cannot_work_with_is_told(surround, given, told):
    with pytest.raises(InputError, match=told):
        surround(**given)
