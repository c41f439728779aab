"""SurroundMonitor: what a robot with three beams knows of its surroundings."""

import math

import pytest

from rocs_bt.clock import Rate, SimulatedClock
from rocs_bt.control.drive import make_drive
from rocs_bt.control.ways import BENDS
from rocs_bt.device import Reading, Sensor
from rocs_bt.errors import InputError
from rocs_bt.event import ListSink
from rocs_bt.geometry import Pose2, Twist2, along_arc
from rocs_bt.knowledge import Knowledge
from rocs_bt.monitor import SurroundMonitor, Watched
from rocs_bt.signal import Signal
from rocs_bt.units import ANGLE, LENGTH, SPEED, TURN_RATE

NONE = [math.inf] * 3
GROUPS = {
    "front": {"beams": [0, 1, 2]},
    "left_gap": {"beams": [0]},
    "right_gap": {"beams": [2]},
    "rear": {"blind": True},
}
GIVEN = {
    "beams": 3,
    "group": GROUPS,
    "mounts": [(0.3, 0.1, 0.6), (0.3, 0.0, 0.0), (0.3, -0.1, -0.6)],
    "half_angle": 0.26,
    "reach": 1.0,
    "memory": 10.0,
    "ground": 10.0,
    "peer_radius": 0.25,
    "reaction": 0.1,
    "deceleration": 2.0,
}


class Ranges(Sensor):
    """Says what the test wants."""

    def __init__(self, clock):
        super().__init__("ranges")
        self.clock, self.values = clock, NONE

    def read(self):
        return Reading(self.clock.now(), list(self.values))


class Rig:
    """A robot of 0.7 x 0.6 m at the origin, and one peer wherever a test puts it."""

    def __init__(self, **given):
        self.clock = SimulatedClock(0.05)
        self.knowledge = Knowledge("R3", self.clock, ListSink())
        self.knowledge.robot.drive = make_drive(
            "differential", track=0.6, max_wheel_speed=2.0, max_wheel_acceleration=1.5
        )
        self.knowledge.graph.set("R3", length=0.7, width=0.6)
        self.sensor, self.count = Ranges(self.clock), 0
        watched = [Watched(self.sensor, Rate(1, 0.05))]
        self.monitor = SurroundMonitor("range", watched, self.knowledge, ListSink(), **{**GIVEN, **given})
        declared = [
            Signal("pose", 3, (LENGTH, LENGTH, ANGLE)),
            Signal("speed", 1, (SPEED,)),
            Signal("turn_rate", 1, (TURN_RATE,)),
            Signal("peer_range", 2, (LENGTH,)),
        ]
        for signal in [*self.monitor.signals(), *declared]:
            self.knowledge.signals.declare(signal)
        self.knowledge.signals.freeze()
        self.peers(math.inf, math.inf)
        self.at(Pose2(0.0, 0.0, 0.0))

    def at(self, pose, speed=0.0, turn=0.0):
        for name, values in (("pose", pose), ("speed", [speed]), ("turn_rate", [turn])):
            self.knowledge.signals.write(name, values, self.clock.now())

    def peers(self, *ranges):
        self.knowledge.signals.write("peer_range", ranges, self.clock.now())

    def peer(self, pose, speed=0.0, name="R1"):
        if not self.knowledge.graph.has(name):
            self.knowledge.graph.add(name, "peer", tag=1)
        self.knowledge.graph.set(name, pose=pose, speed=speed, turn_rate=0.0)

    def groups(self, values=NONE):
        self.sensor.values = values
        self.monitor.run(self.clock.now(), self.count)
        read = {name: self.knowledge.signals.read(name, self.clock.now()).min() for name in GROUPS}
        self.count += 1
        self.clock.advance()
        return read

    def look_round(self, pose):
        """Turn once about, where nothing is."""
        for i in range(25):
            self.at(pose._replace(yaw=pose.yaw + 0.25 * i))
            self.groups()
        self.at(pose)

    def room(self, name):
        return self.knowledge.signals.read(name, self.clock.now() - 0.05).tolist()


def wait(rig, duration):
    for _ in range(round(duration / 0.05)):
        rig.clock.advance()
    rig.peers(math.inf, math.inf)
    rig.at(Pose2(0.0, 0.0, 0.0))


@pytest.fixture
def rig():
    return Rig()


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


def test_it_keeps_to_its_way_off_for_a_while():
    begun, fresh = Rig(), Rig()
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
    wait(begun, 1.2)
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
        wait(rig, 1.0)
        assert rig.groups()["front"] < 0.2
    wait(rig, 1.2)
    assert rig.groups()["front"] == math.inf


def test_what_a_reflex_drives_over_was_seen_lately():
    rig = Rig(ground=60.0, memory=1.0)
    rig.look_round(Pose2(0.0, 0.0, 0.0))
    for _ in range(40):
        rig.clock.advance()
    rig.peers(math.inf, math.inf)
    rig.at(Pose2(0.0, 0.0, 0.0))
    rig.peer(Pose2(0.95, 0.0, math.pi), speed=0.3)
    found = rig.groups()
    assert rig.room("room_behind")[2] > 0.4  # where a plan may send it
    assert max(found["front"], found["rear"]) < 0.2
    for _ in range(4):
        wait(rig, 1.2)
        assert rig.groups()["rear"] < 0.2
    wait(rig, 1.2)
    assert rig.groups()["rear"] > 0.2  # held up for so long it goes where it may


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
    assert rig.room("room_behind")[2] == pytest.approx(0.35, abs=0.11)  # what it saw is behind it now
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


def test_it_tells_how_far_it_may_turn_before_a_corner_comes_to_what_it_saw():
    rig = Rig(ground=20.0, memory=5.0)
    rig.groups()
    assert rig.room("free_turn") == [pytest.approx(math.pi)] * 2
    rig.at(Pose2(0.1, 0.0, 0.0))  # it looks again where it has moved
    rig.groups([math.inf, 0.5, math.inf])  # 0.45 m before the hull
    for after in (0.0, 10.0, 25.0):
        wait(rig, after - rig.clock.now())
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


def test_free_ground_is_forgotten_in_its_time():
    rig = Rig(ground=3.0, memory=1.0)
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


def test_an_old_echo_is_forgotten():
    rig = Rig(memory=1.0)
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
    for _ in range(1220):
        rig.clock.advance()
    rig.peers(math.inf, math.inf)
    rig.at(Pose2(0.0, 0.0, 0.0))
    assert rig.groups()["front"] == math.inf


def test_without_its_pose_or_its_robot_sensor_nothing_is_known(rig):
    rig.peers(math.nan, math.inf)
    assert all(map(math.isnan, rig.groups().values()))
    rig.peers(math.inf, math.inf)
    rig.at(Pose2(math.nan, 0.0, 0.0))
    assert all(map(math.isnan, rig.groups().values()))


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"memory": 0.0}, "must be above 0"),
        ({"ground": 5.0}, "at least as long as memory, found 5 s and 10 s"),
        ({"mounts": [(0.0, 0.0, 0.0)]}, "x, y and yaw of 3 beams"),
        ({"group": {"front": {"beams": [0]}}}, "left_gap"),
    ],
)
def test_what_it_cannot_work_with_is_told(given, told):
    with pytest.raises(InputError, match=told):
        Rig(**given)
