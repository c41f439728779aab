"""A recording as a rosbag2: read back by rosbags and by mcap-ros2-support, compared with the events of the run."""

import math
import sqlite3
import sys

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from msgspec.structs import replace
from ruamel.yaml import YAML

from rocs_bt.base.errors import RecordingError
from rocs_bt.catalog import Catalog
from rocs_bt.event import ActuatorCommanded, BodyMoved, RuleChanged, SensorRead, SignalsWritten
from rocs_bt.record import Recording
from rocs_bt.ros2.bags.export import export_rosbag, start_time

from .conftest import read

SEPARATION, RADIUS = 0.331, 0.0975  # of the Pioneer P3-DX [m]


def seconds(stamp):
    return stamp.sec + stamp.nanosec * 1e-9


def decoded(bag, **options):
    """Messages of an MCAP bag as mcap-ros2-support reads them: topic, log time [ns] and message."""
    (file,) = bag.glob("*.mcap")
    with file.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        for _, channel, message, content in reader.iter_decoded_messages(**options):
            yield channel.topic, message.log_time, content


def by_mcap(bag):
    """Messages of an MCAP bag by topic: log time [ns] and message."""
    found = {}
    for topic, time, message in decoded(bag):
        found.setdefault(topic, []).append((time, message))
    return found


def events_of(recording, kind, **fields):
    found = [e for e in recording.events() if isinstance(e, kind)]
    return [e for e in found if all(getattr(e, name) == value for name, value in fields.items())]


def yaw_of(q):
    return math.atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y**2 + q.z**2))


@pytest.fixture(scope="module", params=["rosbags", "mcap-ros2-support"])
def topics(request, read_export, exp1_bag):
    return read_export("exp1") if request.param == "rosbags" else by_mcap(exp1_bag)


def test_ranges_are_those_of_the_sensor(exp1, topics):
    reads = events_of(exp1, SensorRead, sensor="sonar")
    for beam in range(16):
        messages = topics[f"/range/sonar{beam}"]
        assert [time for time, _ in messages] == [round(e.t * 1e9) for e in reads]
        np.testing.assert_array_equal([m.range for _, m in messages], np.float32([e.values[beam] for e in reads]))
        first = messages[0][1]
        assert (first.radiation_type, first.max_range) == (0, 1.0)
        assert first.field_of_view == pytest.approx(math.radians(30.0))
        assert first.min_range == pytest.approx(0.1)


def test_odometry_is_the_estimate_of_the_robot(exp1, topics):
    poses = [(e.t, e.values["pose"]) for e in events_of(exp1, SignalsWritten, monitor="pose")]
    motion = [e.values for e in events_of(exp1, SignalsWritten, monitor="wheels")]
    assert len(topics["/odom"]) == len(poses) > 100
    for (time, message), (t, (x, y, yaw)), moves in zip(topics["/odom"], poses, motion, strict=True):
        assert (time, seconds(message.header.stamp)) == (round(t * 1e9), pytest.approx(t))
        assert (message.header.frame_id, message.child_frame_id) == ("odom", "base_link")
        position, twist = message.pose.pose.position, message.twist.twist
        assert (position.x, position.y, position.z) == (x, y, 0.0)
        assert math.remainder(yaw_of(message.pose.pose.orientation) - yaw, math.tau) == pytest.approx(0.0, abs=1e-12)
        assert [twist.linear.x, twist.angular.z] == [moves["speed"][0], moves["turn_rate"][0]]


def test_commands_are_twists(exp1, topics):
    commands = events_of(exp1, ActuatorCommanded)
    for (time, message), event in zip(topics["/cmd_vel"], commands, strict=True):
        left, right = event.values
        assert time == round(event.t * 1e9)
        assert message.twist.linear.x == pytest.approx((left + right) / 2.0, abs=1e-12)
        assert message.twist.angular.z == pytest.approx((right - left) / SEPARATION, abs=1e-12)
    assert message.twist.linear.x == 0.0  # the last command stops the robot


def test_ground_truth_of_all_bodies(exp1, topics):
    for body, topic in (("R2", "/ground_truth"), ("R1", "/r1/ground_truth")):
        moved = events_of(exp1, BodyMoved, body=body)
        for (_, message), event in zip(topics[topic], moved, strict=True):
            assert message.header.frame_id == "map"
            assert (message.pose.position.x, message.pose.position.y) == (event.x, event.y)


def test_rules_mission_goal_and_log(exp1, topics):
    changes = events_of(exp1, RuleChanged)
    assert len(topics["/rules"]) == len(changes)
    active = [(time, m.data) for time, m in topics["/rules/avoid_collision/AvoidCollision"]]
    fired = {"fired": True, "ended": False}
    assert active == [(round(e.t * 1e9), fired[e.phase]) for e in changes if e.phase in fired]
    assert topics["/mission"][-1][1].data == "GoTo goal: SUCCESS (GoTo succeeded)"
    ((_, goal),) = topics["/goal_pose"]
    assert (goal.pose.position.x, goal.pose.position.y, goal.header.frame_id) == (0.0, 0.0, "map")
    lines = [(m.level, m.name, m.msg) for _, m in topics["/rosout"]]
    assert (20, "R2", "outcome: success") in lines
    assert any(level == 30 and "AvoidCollision fired (min(front)" in text for level, _, text in lines)


def test_clock_ticks_each_control_period_before_the_messages_of_the_period(exp1, exp1_bag):
    last = 0
    for topic, time, message in decoded(exp1_bag, log_time_order=False):
        if topic == "/clock":
            last = round(seconds(message.clock) * 1e9)
        assert time <= last
    assert last == round(max(e.t for e in exp1.events()) * 1e9)


def frames(topics):
    """Parents of all frames, over the whole bag."""
    found = {}
    for topic in ("/tf_static", "/tf"):
        for _, message in topics[topic]:
            for each in message.transforms:
                found.setdefault(each.child_frame_id, set()).add(each.header.frame_id)
    return found


@pytest.mark.parametrize(("scenario", "duration"), [("exp1", None), ("exp3", 2.0), ("exp1_mecanum", 2.0)])
def test_frames_are_one_tree(read_export, scenario, duration):
    topics = read_export(scenario, duration)
    parents = frames(topics)
    assert all(len(found) == 1 for found in parents.values())
    used = {m.header.frame_id for messages in topics.values() for _, m in messages if hasattr(m, "header")} - {""}
    for frame in used:
        while frame != "map":
            (frame,) = parents[frame]


def test_each_of_several_agents_has_a_namespace(read_export):
    topics = read_export("exp3", 2.0)
    assert {"/r2/odom", "/r3/odom", "/r2/cmd_vel", "/r3/cmd_vel", "/r1/ground_truth"} <= set(topics)
    assert "/odom" not in topics
    assert topics["/r3/odom"][0][1].child_frame_id == "r3/base_link"
    assert {("r2/odom", "map"), ("r3/base_link", "r3/odom"), ("r1", "map")} <= {
        (child, parent) for child, (parent,) in frames(topics).items()
    }


def test_echoes_of_a_scan_are_where_the_rays_hit(record, read_export):
    recording, topics = record("exp1_mecanum", 2.0), read_export("exp1_mecanum", 2.0)
    body = next(b for b in recording.header.bodies if b.fans)
    ((sensor, fan),) = body.fans.items()
    (mount,) = [t for _, m in topics["/tf_static"] for t in m.transforms if t.child_frame_id == sensor]
    reads = events_of(recording, SensorRead, sensor=sensor, agent=body.name)
    assert len(reads) > 10
    turned = yaw_of(mount.transform.rotation)
    for (_, scan), event in zip(topics["/scan"], reads, strict=True):
        hits = np.isfinite(event.values)
        np.testing.assert_array_equal(np.isfinite(scan.ranges), hits)
        for angles, origin, ranges in (
            (fan.yaw + fan.step * np.arange(fan.rays), (fan.x, fan.y), np.array(event.values)),
            (turned + scan.angle_min + scan.angle_increment * np.arange(fan.rays), None, scan.ranges),
        ):
            at = origin or (mount.transform.translation.x, mount.transform.translation.y)
            points = [at[i] + ranges[hits] * f(angles[hits]) for i, f in enumerate((np.cos, np.sin))]
            if origin:
                expected = points
        np.testing.assert_allclose(points, expected, atol=1e-4)
        assert scan.angle_max == pytest.approx(scan.angle_min + (fan.rays - 1) * scan.angle_increment, abs=1e-4)
        assert float(scan.range_max) == pytest.approx(fan.reach)


def test_frames_of_beams_that_look_up_and_down_are_vertical(read_export):
    topics = read_export("inspect", 0.5)
    mounts = {t.child_frame_id: t.transform.rotation for _, m in topics["/tf_static"] for t in m.transforms}
    for site, up in (("up", 1.0), ("down", -1.0)):
        turn = mounts[site]
        assert 2.0 * (turn.x * turn.z - turn.w * turn.y) == pytest.approx(up)  # z of the x axis of the frame


def test_a_gyro_is_an_imu_without_orientation(record, read_export):
    reads = events_of(record("exp3_localised", 0.5), SensorRead, sensor="gyro")
    messages = read_export("exp3_localised", 0.5)[f"/{reads[0].agent.lower()}/imu"]
    assert [m.angular_velocity.z for _, m in messages] == [e.values[0] for e in reads]
    assert messages[0][1].orientation_covariance[0] == messages[0][1].linear_acceleration_covariance[0] == -1.0


def test_sqlite_has_the_same_messages_as_mcap(record, export):
    recording = record("exp1", 2.0)
    bags = [export(recording, storage, storage=storage) for storage in ("mcap", "sqlite3")]
    first, second = ([(t, time, str(m)) for t, ms in sorted(read(bag).items()) for time, m in ms] for bag in bags)
    assert first == second
    (file,) = bags[1].glob("*.db3")
    with sqlite3.connect(file) as base:
        assert base.execute("select count(*) from messages").fetchone() == (len(first),)


@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
def test_equal_recordings_give_equal_bytes(record, export, storage):
    recording = record("exp1", 2.0)
    one, two = (export(recording, f"{i}/bag", storage=storage) for i in (1, 2))
    assert {f.name: f.read_bytes() for f in one.iterdir()} == {f.name: f.read_bytes() for f in two.iterdir()}


def test_metadata_describe_the_bag(exp1_bag):
    information = YAML(typ="safe").load(exp1_bag / "metadata.yaml")["rosbag2_bagfile_information"]
    topics = {each["topic_metadata"]["name"]: each for each in information["topics_with_message_count"]}
    offered = {name: each["topic_metadata"]["offered_qos_profiles"] for name, each in topics.items()}
    assert (information["version"], information["storage_identifier"]) == (9, "mcap")
    assert sum(each["message_count"] for each in topics.values()) == information["message_count"]
    assert all(each["topic_metadata"]["type_description_hash"].startswith("RIHS01_") for each in topics.values())
    latched = {name for name, (profile,) in offered.items() if profile["durability"] == "transient_local"}
    assert latched == {"/tf_static", "/scene"}


def test_the_scene_shows_the_ground(record, read_export):
    recording = record("patrol_rough", 0.2)
    ((_, scene),) = read_export("patrol_rough", 0.2)["/scene"]
    drawn = [len(marker.points) for marker in scene.markers if marker.ns == "ground"]
    assert drawn == [5] * len(recording.header.grounds)
    assert drawn


def test_times_begin_at_the_given_start(record, export):
    topics = read(export(record("exp1", 2.0), start=start_time("2026-11-20T10:00:00+01:00")))
    assert topics["/clock"][0][0] == 1763629200_000000000 + 365 * 86400_000000000
    assert seconds(topics["/odom"][1][1].header.stamp) == pytest.approx(topics["/odom"][1][0] * 1e-9)


def test_a_recording_that_was_cut_off_is_exported_to_its_end(exp1, tmp_path, rocs_bt):
    cut = tmp_path / "run.mcap"
    cut.write_bytes(exp1.path.read_bytes()[: exp1.path.stat().st_size // 2])
    told = rocs_bt("export", str(cut), "--rosbag", str(tmp_path / "bag"))
    end = max(event.t for event in Recording.open(cut).events())
    assert (told.code, told.err) == (0, f"the recording '{cut}' was cut off; it is read up to t = {end:.2f} s.\n")
    assert max(time for messages in read(tmp_path / "bag").values() for time, _ in messages) == round(end * 1e9)


def test_an_unknown_robot_leaves_out_what_needs_its_drivers(record, tmp_path, monkeypatch):
    monkeypatch.setattr(Catalog, "load_robot", lambda self, name: self.find("robot", "no_such_robot"))
    bag = export_rosbag(record("exp1", 2.0), tmp_path / "bag")
    assert bag.unknown_robots == ("pioneer_p3dx",)
    assert {"/odom", "/range/sonar0", "/commands/wheels", "/sensors/encoders"} <= set(bag.topics)
    assert not {"/cmd_vel", "/joint_states"} & set(bag.topics)


def test_the_command_lists_topics(record, tmp_path, rocs_bt):
    told = rocs_bt("export", str(record("exp1", 2.0).path.parent), "--rosbag", str(tmp_path / "bag"))
    assert told.code == 0
    assert any(line.split() == ["/odom", "40", "nav_msgs/msg/Odometry"] for line in told.out.splitlines()), told.out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--rosbag", "."], "'.' exists. Choose another folder"),
        (["--rosbag", "bag", "--start", "noon"], "'noon' is no time. Write seconds since 1970"),
        (
            ["--rosbag", "bag", "--start", "-1"],
            "the start time must be 0 to 2147483647 seconds since 1970, found -1 s.",
        ),
        (["--rosbag", "bag", "--start", "1e300"], "the start time must be"),
        (["--rosbag", "bag", "--storage", "bag"], "'bag' is not one of 'mcap', 'sqlite3'"),
        ([], "Missing option '--rosbag'"),
    ],
)
def test_wrong_options(record, tmp_path, rocs_bt, monkeypatch, arguments, message):
    monkeypatch.chdir(tmp_path)
    told = rocs_bt("export", str(record("exp1", 2.0).path), *arguments)
    assert told.code == 2
    assert message in " ".join(told.err.split())
    assert not (tmp_path / "bag").exists()


def test_without_rosbags_the_error_says_what_to_install(record, tmp_path, rocs_bt, monkeypatch):
    for name in [name for name in sys.modules if name.split(".")[0] == "rosbags"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "rosbags", None)
    told = rocs_bt("export", str(record("exp1", 2.0).path), "--rosbag", str(tmp_path / "bag"))
    assert told.code == 2
    assert "pip install 'rocs_bt[ros2]'" in told.err


def test_a_failed_export_leaves_no_folder(record, tmp_path, monkeypatch):
    recording = record("exp1", 2.0)

    def events():
        yield next(iter(Recording.events(recording)))
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(recording, "events", events)
    with pytest.raises(OSError, match="No space left"):
        export_rosbag(recording, tmp_path / "bag")
    assert not (tmp_path / "bag").exists()


@pytest.mark.parametrize("t", [1e6, -5.0, math.nan, math.inf])
def test_a_time_that_no_run_has_ends_the_export(exp1, tmp_path, t):
    class Damaged:
        header = exp1.header

        def events(self):
            events = list(exp1.events())
            return [*events[:20], replace(events[20], t=t), *events[21:]]

    with pytest.raises(RecordingError, match="the recording is damaged: an event at"):
        export_rosbag(Damaged(), tmp_path / "bag")
    assert not (tmp_path / "bag").exists()
