"""A bag as the sensors of a robot: `rocs-bt replay --bag`."""

import re
import sqlite3
import sys

import numpy as np
import pytest
from rosbags.typesys import get_types_from_msg
from ruamel.yaml import YAML

from rocs_bt.event import KnowledgeChanged, RuleChanged, SignalsWritten
from rocs_bt.record import Recording
from rocs_bt.record.figures import rules
from rocs_bt.record.fold.arrays import signal_table

from . import robots
from .robots import LATCHES, ForeignBag, cart, foreign_bag, pioneer

ROW = re.compile(r"^ +(\d+\.\d\d) +(\d+\.\d\d) +\d+\.\d\d  (\S+)", re.MULTILINE)


def firings(out):
    """Rows of a table of firings: from [s], to [s], rule."""
    return [(float(a), float(b), rule) for a, b, rule in ROW.findall(out)]


@pytest.fixture
def project(tmp_path, monkeypatch):
    """An empty project. Pictures of rules are not drawn: tests/cli/test_rules_on_runs.py looks at them."""
    monkeypatch.setattr(rules, "render_canvas", lambda name, make, form: name.encode())
    folder = tmp_path / "project"
    for name in ("robots", "rules", "planners", "scenarios"):
        (folder / name).mkdir(parents=True)
    monkeypatch.chdir(folder)
    return folder


def replay(rocs_bt, bag, *more, robot="cart", rules="wall"):
    chosen = ["--rules", rules] if rules else []
    return rocs_bt("replay", "--bag", bag, "--robot", robot, *chosen, *more)


@pytest.mark.parametrize("options", [{}, {"ros2": "use_sim_time = true"}], ids=["log time", "simulated time"])
def test_rules_fire_on_an_exported_run_as_in_the_run(project, exp1, exp1_bag, rocs_bt, options):
    pioneer(project, **options)
    told = replay(rocs_bt, exp1_bag, robot="pioneer", rules="avoid_collision")
    assert told.code == 0, told.err
    phases = {"latched": [], "released": []}
    for event in exp1.events():
        if isinstance(event, RuleChanged) and event.phase in phases:
            phases[event.phase].append(event.t)
    found = firings(told.out)
    assert len(found) == 3
    assert [a for a, _, _ in found] == pytest.approx(phases["latched"], abs=0.051)
    assert [b for _, b, _ in found] == pytest.approx(phases["released"], abs=0.051)


def test_the_shipped_pioneer_reads_the_export_of_its_run(project, exp1, exp1_bag, rocs_bt):
    told = replay(rocs_bt, exp1_bag, robot="pioneer_p3dx_ros2", rules="avoid_collision")
    latched = [e.t for e in exp1.events() if isinstance(e, RuleChanged) and e.phase == "latched"]
    assert [begin for begin, _, _ in firings(told.out)] == pytest.approx(latched, abs=0.051)


def test_signals_are_those_of_the_run(project, exp1, exp1_bag, rocs_bt):
    pioneer(project)
    assert replay(rocs_bt, exp1_bag, robot="pioneer", rules="").code == 0
    again = signal_table(Recording.open("runs/exp1"), "pioneer")
    again = again[again["time"] < 13.0]  # then the mission drops its goal
    first = signal_table(exp1, "R2")[: len(again)]
    np.testing.assert_allclose(again["time"], first["time"], atol=1e-9)
    for name in ("front", "left_gap", "pose", "speed", "turn_rate", "stop_distance", "goal_distance"):
        np.testing.assert_allclose(again[name], first[name], atol=1e-6, err_msg=name)


def test_a_pose_comes_through_transforms(project, exp1, exp1_bag, rocs_bt):
    pioneer(project, pose=robots.TF)
    assert replay(rocs_bt, exp1_bag, robot="pioneer", rules="").code == 0
    again = signal_table(Recording.open("runs/exp1"), "pioneer", ["pose"])
    np.testing.assert_allclose(again["pose"], signal_table(exp1, "R2", ["pose"])["pose"][: len(again)], atol=1e-6)


def test_a_robot_among_several_is_read_by_its_namespace(project, record, export, rocs_bt):
    run = record("exp3", 2.0)
    pioneer(project, ros2='namespace = "r2"')
    assert replay(rocs_bt, export(run), robot="pioneer", rules="").code == 0
    again = signal_table(Recording.open("runs/bag"), "pioneer", ["pose"])
    np.testing.assert_allclose(again["pose"], signal_table(run, "R2", ["pose"])["pose"][: len(again)], atol=1e-6)


@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("drive", {}),
        ("drive", {"storage": "SQLITE3"}),
        ("drive", {"compression": "STORAGE"}),
        ("drive", {"compression": "MESSAGE"}),
        ("drive", {"compression": "FILE"}),
        ("drive", {"compression": "FILE", "storage": "SQLITE3"}),
        ("drive", {"distro": "HUMBLE"}),
        ("drive.bag", {}),
    ],
    ids=lambda value: value if isinstance(value, str) else " ".join(value.values()) or "MCAP",
)
def test_a_foreign_bag(project, rocs_bt, name, options):
    cart(project)
    told = replay(rocs_bt, foreign_bag(project / name, **options))
    assert told.code == 0, told.err
    ((begin, end, rule),) = firings(told.out)
    assert rule == "wall/Wall"
    # Odometry and scans are 0.1 s apart, and the nearest beam is not exactly ahead.
    assert begin == pytest.approx(LATCHES, abs=0.11)
    assert end > 5.3
    assert "  lidar: /scan (61 messages)\n" in told.out


def test_a_single_file_is_a_bag(project, rocs_bt):
    cart(project)
    bag = foreign_bag(project / "drive")
    (bag / "metadata.yaml").unlink()
    for path in (bag, bag / "drive.mcap"):
        assert len(firings(replay(rocs_bt, path).out)) == 1


def test_recording_of_a_bag_is_input_of_the_other_commands(project, rocs_bt):
    cart(project)
    told = replay(rocs_bt, foreign_bag(project / "drive"), "--out", "lab")
    assert firings(rocs_bt("rules", "replay", "wall", "lab").out) == firings(told.out)
    tuned = rocs_bt(
        "rules", "tune", "wall", "lab", "--rule", "Wall", "--threshold", "near", "--from", "2 cm", "--to", "1 m"
    )
    counts = {float(row[0]): int(row[1]) for row in re.findall(r"^ +([\d.]+) +(\d)\b", tuned.out, re.MULTILINE)}
    assert (tuned.code, counts[0.5], min(counts.values()), max(counts.values())) == (0, 1, 0, 1)
    assert rocs_bt("report", "lab").code == 0
    assert rocs_bt("plot", "lab").code == 0


def test_nothing_is_commanded(project, rocs_bt):
    cart(project)
    assert replay(rocs_bt, foreign_bag(project / "drive")).code == 0
    kinds = {type(event).__name__ for event in Recording.open("runs/drive").events()}
    assert kinds >= {"SensorRead", "SignalsWritten", "BodyMoved"}
    assert not kinds & {"TicketChanged", "AtomicStarted", "RuleChanged", "BlockFailed", "ContentRaised"}


def test_equal_bags_give_equal_recordings(project, rocs_bt):
    cart(project)
    bag = foreign_bag(project / "drive")
    assert [replay(rocs_bt, bag, "--out", out).code for out in ("a", "b")] == [0, 0]
    assert (project / "a" / "run.mcap").read_bytes() == (project / "b" / "run.mcap").read_bytes()


def test_a_part_of_a_bag(project, rocs_bt):
    cart(project)
    bag = foreign_bag(project / "drive")
    ((begin, _, _),) = firings(replay(rocs_bt, bag, "--from", "2").out)
    assert begin == pytest.approx(LATCHES - 2.0, abs=0.11)
    assert firings(replay(rocs_bt, bag, "--from", "1", "--for", "2").out) == []
    last = max(event.t for event in Recording.open("runs/drive").events())
    assert last == pytest.approx(2.0, abs=0.11)


def test_types_of_the_bag_itself(project, rocs_bt):
    definitions = get_types_from_msg("std_msgs/Header header\nfloat64 nearest\n", "lab_msgs/msg/Nearest")
    more = """
        [[sensor]]
        name = "nearest"
        driver = "ros2"
        topic = "nearest"
        type = "lab_msgs/msg/Nearest"
        values = ["nearest"]
        unit = "cm"
        signal = "nearest"
        monitor = "nearest"
        [[monitor]]
        name = "nearest"
        class = "nearest.py:Nearest"
        sensors = ["nearest"]
    """
    cart(project, more=more)
    (project / "robots" / "cart" / "nearest.py").write_text(
        "from rocs_bt import Monitor, Signal\n\n\n"
        "class Nearest(Monitor):\n"
        "    def signals(self):\n"
        '        return [Signal("nearest")]\n\n'
        "    def expects(self):\n"
        '        return {"nearest": 1}\n\n'
        "    def interpret(self, readings):\n"
        '        return {"nearest": readings["nearest"].values}\n'
    )
    with ForeignBag(project / "drive", definitions=definitions) as bag:
        bag.drive()
        header = bag.header(0.0, "lidar")
        bag.add("/nearest", 0.0, bag.message("lab_msgs/msg/Nearest", header=header, nearest=42.0))
    told = replay(rocs_bt, project / "drive")
    assert told.code == 0, told.err
    events = Recording.open("runs/drive").events()
    written = [e.values["nearest"] for e in events if isinstance(e, SignalsWritten) and e.monitor == "nearest"]
    assert written[0] == [pytest.approx(0.42)]


def test_times_of_a_simulator(project, rocs_bt):
    """A bag of a simulation at half the real speed, with headers of simulated time."""
    cart(project, ros2="use_sim_time = true")
    with ForeignBag(project / "drive") as bag:
        add, start, bag.start = bag.add, bag.start, 0
        time = bag.store.types["builtin_interfaces/msg/Time"]

        def late(topic, t, message):
            bag.start = start
            add(topic, 2.0 * t, message)
            bag.start = 0

        for tick in range(601):
            at = tick * 10_000_000
            clock = bag.message("rosgraph_msgs/msg/Clock", clock=time(sec=at // 10**9, nanosec=at % 10**9))
            late("/clock", at * 1e-9, clock)
        bag.add = late
        bag.drive()
    ((begin, _, _),) = firings(replay(rocs_bt, project / "drive").out)
    assert begin == pytest.approx(LATCHES, abs=0.13)


def test_a_goal_of_the_bag_is_pursued(project, exp1_bag, rocs_bt):
    pioneer(project)
    assert replay(rocs_bt, exp1_bag, robot="pioneer", rules="").code == 0
    events = [e for e in Recording.open("runs/exp1").events() if isinstance(e, KnowledgeChanged)]
    assert [e.value for e in events if e.name == "pursues"] == ["goal_pose"]


def test_a_missing_topic_names_those_of_its_type(project, rocs_bt):
    cart(project, scan="front_scan")
    told = replay(rocs_bt, foreign_bag(project / "drive"))
    assert told.code == 2
    assert re.search(r"robots/cart/robot.toml:\d+.*sensor 'lidar' reads '/front_scan', but the bag '.*drive'", told.err)
    assert "Topics of type sensor_msgs/msg/LaserScan: '/scan'" in told.err


def test_an_optional_sensor_may_be_missing(project, rocs_bt):
    cart(project, scan="front_scan", lidar="optional = true")
    told = replay(rocs_bt, foreign_bag(project / "drive"))
    assert told.code == 0, told.err
    assert "lidar: not in the bag" in told.out
    assert firings(told.out) == []


def test_another_type_of_a_topic(project, rocs_bt):
    cart(project, scan="odom")
    told = replay(rocs_bt, foreign_bag(project / "drive"))
    assert told.code == 2
    assert "sensor 'lidar' reads sensor_msgs/msg/LaserScan, but '/odom' in the bag" in told.err
    assert "is nav_msgs/msg/Odometry" in told.err


def test_a_robot_without_ros(project, rocs_bt):
    told = replay(rocs_bt, foreign_bag(project / "drive"), robot="pioneer_p3dx", rules="")
    assert told.code == 2
    assert "the robot 'pioneer_p3dx' reads no topic of the bag" in told.err


def without_definitions(bag):
    """Remove the definitions of types, which bags of old distributions do not have."""
    (file,) = bag.glob("*.db3")
    with sqlite3.connect(file) as base:
        base.execute("delete from message_definitions")
    base.close()
    return bag


def test_a_bag_without_definitions_has_the_types_of_its_distribution(project, rocs_bt):
    cart(project)
    bag = without_definitions(foreign_bag(project / "drive", storage="SQLITE3"))
    assert len(firings(replay(rocs_bt, bag).out)) == 1


def test_a_type_of_another_distribution(project, rocs_bt):
    definitions = get_types_from_msg("std_msgs/Header header\nfloat32[] ranges\n", "sensor_msgs/msg/LaserScan")
    cart(project)
    with ForeignBag(project / "drive", storage="SQLITE3") as bag:
        for store in (bag.store.types, bag.store.fielddefs):
            store.pop("sensor_msgs/msg/LaserScan")
        bag.store.register(definitions)

        def scan(t, x):
            header, ranges = bag.header(t, "lidar"), np.ones(9, np.float32)
            return bag.message("sensor_msgs/msg/LaserScan", header=header, ranges=ranges)

        bag.drive(scan)
    told = replay(rocs_bt, without_definitions(project / "drive"))
    assert told.code == 2
    assert "the type sensor_msgs/msg/LaserScan of topic '/scan' is not that of Jazzy" in told.err


def test_the_distribution_of_a_type_is_named(project, exp1, rocs_bt):
    """sensor_msgs/msg/Range of Humble has no variance."""
    pioneer(project)
    with ForeignBag(project / "drive", storage="SQLITE3", distro="HUMBLE") as bag:
        bag.add("/odom", 0.0, bag.odometry(0.0, 0.0, 0.0))
        joint = bag.message(
            "sensor_msgs/msg/JointState",
            header=bag.header(0.0, ""),
            name=["left_wheel", "right_wheel"],
            position=np.zeros(2),
            velocity=np.zeros(2),
            effort=np.zeros(2),
        )
        bag.add("/joint_states", 0.0, joint)
        fields = {"radiation_type": 0, "field_of_view": 0.5, "min_range": 0.1, "max_range": 1.0, "range": 0.7}
        for i in range(16):
            message = bag.message("sensor_msgs/msg/Range", header=bag.header(0.0, ""), **fields)
            bag.add(f"/range/sonar{i}", 0.0, message)
    told = replay(rocs_bt, without_definitions(project / "drive"), robot="pioneer", rules="")
    assert told.code == 2
    assert 'Write distro = "humble" in [ros2].' in told.err or 'Write distro = "iron" in [ros2].' in told.err


def test_a_clock_that_was_set_during_the_recording(project, rocs_bt):
    cart(project)
    with ForeignBag(project / "drive") as bag:
        bag.drive()
        bag.add("/odom", 3e8, bag.odometry(3e8, 0.0, 0.0))
    told = replay(rocs_bt, project / "drive")
    assert told.code == 2
    assert "has no message for 299999994 s from 6.0 s on: the clock was set" in told.err
    assert len(firings(replay(rocs_bt, project / "drive", "--for", "60").out)) == 1


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda bag: (bag / "drive.mcap").write_bytes((bag / "drive.mcap").read_bytes()[:9000]), "mcap recover"),
        (lambda bag: (bag / "drive.mcap").write_bytes(b""), "seems to be empty"),
        (lambda bag: (bag / "drive.mcap").unlink(), "files are missing"),
        (lambda bag: (bag / "metadata.yaml").write_text("rosbag2_bagfile_information: 3"), "Invalid bag metadata"),
        (lambda bag: [file.unlink() for file in bag.iterdir()], "no metadata.yaml, and no file of a bag"),
    ],
    ids=["truncated", "empty file", "no file", "metadata", "empty folder"],
)
def test_a_damaged_bag(project, rocs_bt, spoil, message):
    cart(project)
    bag = foreign_bag(project / "drive")
    spoil(bag)
    told = replay(rocs_bt, bag)
    assert told.code == 2
    assert message in told.err
    assert str(bag) in told.err


def test_an_empty_bag(project, rocs_bt):
    cart(project)
    with ForeignBag(project / "drive"):
        pass
    told = replay(rocs_bt, project / "drive")
    assert told.code == 2
    assert "is empty: it has no messages" in told.err


def test_what_is_no_bag(project, rocs_bt):
    cart(project)
    assert "there is no bag 'nowhere'" in replay(rocs_bt, "nowhere").err
    assert "'robots/cart/robot.toml' is no bag: its name must end in" in replay(rocs_bt, "robots/cart/robot.toml").err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--bag", "drive"], "--bag needs --robot"),
        (["--bag", "drive", "--robot", "cart", "run"], "--bag excludes RUN"),
        (["--bag", "drive", "--robot", "cart", "--why", "3"], "--bag excludes RUN"),
        (["--robot", "cart"], "Missing argument 'RUN', or --bag"),
        (["run", "--robot", "cart"], "need --bag"),
        (["--bag", "drive", "--robot", "cart", "--from", "-1"], "--from must be 0 or more"),
        (["--bag", "drive", "--robot", "cart", "--from", "100"], "has 6.0 s, so it cannot begin at 100 s"),
        (["--bag", "drive", "--robot", "cart", "--rate", "7"], "control rate of 7 Hz"),
        (["--bag", "drive", "--robot", "no"], "no"),
    ],
)
def test_wrong_options(project, rocs_bt, arguments, message):
    cart(project)
    foreign_bag(project / "drive")
    told = rocs_bt("replay", *arguments)
    assert told.code == 2
    assert message in told.err


def test_without_rosbags_the_error_says_what_to_install(project, rocs_bt, monkeypatch):
    cart(project)
    bag = foreign_bag(project / "drive")
    for name in [name for name in sys.modules if name.split(".")[0] == "rosbags"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "rosbags", None)
    told = replay(rocs_bt, bag)
    assert told.code == 2
    assert "pip install 'rocs_bt[ros2]'" in told.err


def test_metadata_of_a_foreign_bag_are_optional(project, rocs_bt):
    """Durations in metadata.yaml are not trusted."""
    cart(project)
    bag = foreign_bag(project / "drive")
    yaml = YAML()
    metadata = yaml.load(bag / "metadata.yaml")
    metadata["rosbag2_bagfile_information"]["duration"]["nanoseconds"] = 10**18
    yaml.dump(metadata, bag / "metadata.yaml")
    assert len(firings(replay(rocs_bt, bag).out)) == 1
