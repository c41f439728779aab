"""A robot that publishes nonsense, nothing, or other types and policies: counted, reported, and never an exception."""

from __future__ import annotations

import json
import re

import pytest

from rocs_bt import ListSink, drive
from rocs_bt.base.errors import DeviceError
from rocs_bt.event import BlockFailed, ContentRaised, RuleChanged, SensorFailed, SignalsWritten

from .exp1 import OPTIONS, start_of, write_project

MAX_AGE, RULE = 0.15, 0.1  # [s] three periods of the scan; `for` of the rule Blind
PERIOD = 0.05  # [s]

# What is told of each fault; an old stamp is no fault of the message: the signal is stale.
DETAILS = {
    "scan_nan": "the reading contains NaN",
    "scan_short": "/r1/scan: the scan covers -180 to -1 deg",
    "scan_empty": "/r1/scan: the scan has 0 beams",
    "stamps_zero": "/r1/scan: the stamp of its header is 0",
    "stamps_future": "s in the future",
    "scan_some_nan": "the reading contains NaN",
    "odom_nan": "the reading contains NaN",
}


@pytest.mark.usefixtures("awake")
def test_faulty_messages_are_counted_and_reported(counterpart, tmp_path):
    robot, sink = counterpart(*OPTIONS, *start_of(1), distribution="jazzy"), ListSink()
    steps = [(0.5 + i, fault) for i, fault in enumerate(DETAILS)]
    steps += [(1.0 + i, "fine") for i in range(len(DETAILS))]
    steps.sort()

    def fault(t: float) -> None:
        while steps and t > steps[0][0]:
            robot.tell(steps.pop(0)[1])

    catalog = write_project(tmp_path, transport="dds")
    found = drive("real", catalog, duration=8.0, sinks=[sink], progress=fault, out=tmp_path / "out")
    assert found.outcomes == {"R2": "timeout"}
    assert not [e for e in sink.events if isinstance(e, (BlockFailed, ContentRaised))]
    details = [e.detail for e in sink.events if isinstance(e, SensorFailed)]
    for detail in DETAILS.values():
        while detail not in details.pop(0):
            assert details, f"{detail} was not reported, or not in time"


@pytest.mark.usefixtures("awake")
def test_a_scan_that_stops_is_stale_and_the_reflex_stops_the_robot(counterpart, tmp_path):
    robot = counterpart(*OPTIONS, *start_of(1), "--fault", "scan_stops", "--after", "1.5", distribution="jazzy")
    sink, catalog = ListSink(), write_project(tmp_path, transport="dds")
    found = drive("real", catalog, duration=4.0, sinks=[sink], out=tmp_path / "out")
    assert found.outcomes == {"R2": "timeout"}
    scans = [e for e in sink.events if isinstance(e, SignalsWritten) and e.monitor == "scan"]
    last = scans[-1].t if scans[-1].stamp is None else scans[-1].stamp
    (stop,) = (e for e in sink.events if isinstance(e, RuleChanged) and e.rule.endswith("Blind") and e.phase == "fired")
    assert stop.t - last <= MAX_AGE + RULE + 2 * PERIOD
    assert "invalid" in stop.reading
    assert robot.end()["speeds"] == [0.0, 0.0]
    (fault,) = json.loads((tmp_path / "out" / "summary.json").read_text())["agents"]["R2"]["faults"]
    assert "sensor lidar failed: stale: its newest sample is" in fault


MISMATCHES = {
    "reliability": (
        {"lidar_reliability": "reliable"},
        (),
        ["reliability", "it offers best_effort, volatile", "robot.toml requests reliable, volatile"],
    ),
    "durability": (
        {"lidar_durability": "transient_local"},
        (),
        ["durability", "it offers best_effort, volatile", "robot.toml requests best_effort, transient_local"],
    ),
    "type": ({}, ("--fault", "scan_string"), ["publishes std_msgs/msg/String, which is another type"]),
}


def refusal(catalog, complete):
    """Text of a refused start; after a longer wait, until all nodes were discovered and the text is complete."""
    for wait in (5.0, 10.0, 20.0):
        with pytest.raises(DeviceError) as caught:
            drive("real", catalog, duration=1.0, wait=wait)
        if complete(str(caught.value)):
            break
    return str(caught.value)


@pytest.mark.parametrize("what", MISMATCHES)
def test_policies_and_types_that_do_not_match_are_reported(counterpart, tmp_path, what):
    changes, options, words = MISMATCHES[what]
    counterpart(*OPTIONS, *options, distribution="jazzy")
    catalog = write_project(tmp_path, transport="dds", **changes)
    words = ["R2/lidar: no sample: '/r1/scan' (sensor_msgs/msg/LaserScan)", "'/r1/robot'", *words]
    text = refusal(catalog, lambda text: text.count("no sample") == 1 and all(word in text for word in words))
    assert not [word for word in words if word not in text]
    assert text.count("no sample") == 1  # all others match


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        (
            {"wheels_type": "geometry_msgs/msg/Twist"},
            "subscribes to geometry_msgs/msg/TwistStamped, which is another type",
        ),
        ({"wheels_reliability": "best_effort"}, r"reliability \(offered best_effort, requested reliable\)"),
        ({"wheels_topic": "cmd"}, "no node subscribes to '/r1/cmd'"),
    ],
)
def test_commands_that_no_node_receives_are_reported_before_the_start(counterpart, tmp_path, changes, text):
    counterpart(*OPTIONS, distribution="jazzy")
    catalog = write_project(tmp_path, transport="dds", **changes)
    pattern = rf"topics without a matching node for \d+ s\.\n  R2/wheels: .*{text}"
    assert re.search(pattern, found := refusal(catalog, lambda found: re.search(pattern, found))), found
