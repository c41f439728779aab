"""Numbers in a recording: named fields for viewers, each scan once, and events that come back bit by bit."""

import json
import math

import numpy as np
import pytest
from mcap.reader import make_reader

from rocs_bt.base.errors import RecordingError
from rocs_bt.event import ActuatorCommanded, SensorRead, SignalsWritten, pack
from rocs_bt.record.file.header import AgentInfo, RunHeader, SignalInfo
from rocs_bt.record.file.recorder import Recorder
from rocs_bt.record.file.recording import Recording
from rocs_bt.record.file.wire import Incoming, Repeat, Signals
from rocs_bt.record.fold.arrays import event_table

WEIRD = (math.nan, -math.nan, math.inf, -math.inf, -0.0, 5e-324, 1e308)
SIGNALS = (SignalInfo(name="front", size=40), SignalInfo(name="speed"), SignalInfo(name="pose", size=3))


def some_events(seed):
    """Readings of two sensors, and signals that repeat parts of them, or not."""
    rng = np.random.default_rng(seed)

    def numbers(count):
        return [float(rng.choice(WEIRD)) if rng.random() < 0.2 else float(x) for x in rng.normal(size=count)]

    events, scan = [], numbers(60)
    for period in range(20):
        t = 0.05 * period
        if rng.random() < 0.8:
            scan = numbers(60)
            events.append(SensorRead(t=t, agent="R2", sensor="lidar", stamp=t, data=pack(scan)))
        events.append(SensorRead(t=t, agent="R2", sensor="gyro", stamp=t - 0.01, data=pack(numbers(3))))
        first = int(rng.integers(0, 20))
        front = scan[first : first + 40] if rng.random() < 0.8 else numbers(40)
        given = {"front": front, "speed": numbers(1), "pose": numbers(3), "none": []}
        names = tuple(rng.permutation(list(given)).tolist())
        sizes = tuple(len(given[name]) for name in names)
        data = b"".join(pack(given[name]) for name in names)
        stamp = None if rng.random() < 0.5 else t - 0.01
        events.append(SignalsWritten(t=t, agent="R2", monitor="m", signals=names, sizes=sizes, data=data, stamp=stamp))
        command = pack(numbers(int(rng.integers(1, 5))))
        events.append(ActuatorCommanded(t=t, agent="R2", actuator="wheels", route="reactive", data=command))
    return events


def recorded(path, events, header=None):
    header = header or RunHeader(
        scenario="x", seed=1, agents=(AgentInfo(name="R2", robot="r", mission="m", signals=SIGNALS),)
    )
    recorder = Recorder(path, header)
    for event in events:
        recorder.emit(event)
    recorder.close()
    return Recording.open(path)


@pytest.mark.parametrize("seed", range(30))
def test_events_come_back_bit_by_bit_whatever_is_asked_for(tmp_path, seed):
    events = some_events(seed)
    recording = recorded(tmp_path / "run.mcap", events)
    assert list(recording.events()) == events
    for kind in (SensorRead, SignalsWritten, ActuatorCommanded):
        wanted = [event for event in events if type(event) is kind]
        assert list(recording.events([kind])) == wanted
        assert [bytes(e.data) for e in recording.events([kind])] == [e.data for e in wanted]
    assert len(event_table(recording, SignalsWritten)) == 20


def test_each_number_is_a_named_field_and_a_scan_is_written_once(tmp_path):
    scan, gyro = [float(i) for i in range(60)], [0.1, 0.2, 0.3]
    front = tuple(scan[10:50])
    events = [
        SensorRead(t=0.0, agent="R2", sensor="lidar", stamp=0.0, data=pack(scan)),
        SensorRead(t=0.0, agent="R2", sensor="gyro", stamp=0.0, data=pack(gyro)),
        SignalsWritten(
            t=0.0,
            agent="R2",
            monitor="m",
            signals=("front", "speed", "pose"),
            sizes=(40, 1, 3),
            data=pack([*front, 0.5, 1.0, 2.0, 3.0]),
        ),
        ActuatorCommanded(t=0.0, agent="R2", actuator="wheels", route="reactive", data=pack([0.4, 0.6])),
    ]
    agents = (AgentInfo(name="R2", robot="r", mission="m", signals=SIGNALS, axes=("vx", "vy", "wz")),)
    flying = ActuatorCommanded(t=0.1, agent="R2", actuator="rotors", route="reactive", data=pack([1.0, 2.0, 3.0]))
    recording = recorded(tmp_path / "run.mcap", [*events, flying], RunHeader(scenario="x", seed=1, agents=agents))
    found = {}
    with open(recording.path, "rb") as file:
        for schema, channel, message in make_reader(file).iter_messages():
            found[channel.topic] = json.loads(schema.data), json.loads(message.data)
    schema, signals = found["/R2/signals"]
    assert signals["values"] == {
        "front": {"sensor": "lidar", "first": 10, "count": 40},
        "speed": 0.5,
        "pose": [1, 2, 3],
    }
    assert schema["properties"]["values"]["properties"]["speed"] == {"type": "number"}
    assert schema["properties"]["values"]["properties"]["pose"] == {"type": "array", "items": {"type": "number"}}
    assert found["/R2/sensors/gyro"][1]["values"] == gyro
    for topic, values in (("wheels", {"left": 0.4, "right": 0.6}), ("rotors", {"vx": 1.0, "vy": 2.0, "wz": 3.0})):
        schema, message = found[f"/R2/commands/{topic}"]
        assert message["values"] == values
        assert schema["properties"]["values"]["properties"] == {key: {"type": "number"} for key in values}


def test_a_repeated_reading_that_is_missing_is_damage():
    with pytest.raises(RecordingError, match="the signals of 'm' repeat a reading of 'lidar'"):
        Incoming().event(Signals(t=0.0, agent="R2", monitor="m", values={"front": Repeat("lidar", 0, 60)}))


def test_an_event_that_cannot_be_recorded_spoils_no_other(tmp_path):
    scan = pack([float(i) for i in range(60)])
    events = [
        SensorRead(t=0.0, agent="R2", sensor="lidar\ud800", stamp=0.0, data=scan),
        SensorRead(t=-1.0, agent="R2", sensor="lidar", stamp=0.0, data=scan),
        SignalsWritten(t=0.0, agent="R2", monitor="m", signals=("front",), sizes=(60,), data=scan),
    ]
    with pytest.raises(RecordingError, match="2 events could not be recorded"):
        recorded(tmp_path / "run.mcap", events)
    assert list(Recording.open(tmp_path / "run.mcap").events()) == events[2:]
