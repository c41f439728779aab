"""What Foxglove-compatible viewers need: a valid MCAP, a schema for each channel, messages that fit it."""

import json
import math

import msgspec
import pytest
from mcap.reader import make_reader

from rocs_bt.base.geometry import Pose2, Pose3
from rocs_bt.event import BlockFailed, BodyMoved, ContactBegan, OutcomeDecided, SensorFailed, SensorRead, pack
from rocs_bt.record import BodyInfo, Outline
from rocs_bt.record.file.header import Beam
from rocs_bt.record.file.recorder import Recorder

from .. import synthetic


def read(path):
    with path.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        found = {}
        for schema, channel, message in reader.iter_messages():
            found.setdefault(channel.topic, (schema, []))[1].append((message, json.loads(message.data)))
        return reader.get_summary(), found


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    recorder = Recorder(tmp_path_factory.mktemp("run") / "run.mcap", synthetic.header())
    for event in synthetic.events(6.0):
        recorder.emit(event)
    recorder.emit(SensorFailed(t=6.0, agent="R2", sensor="sonar", detail="no answer"))
    recorder.emit(BlockFailed(t=6.0, agent="R2", block="R2/monitor sonar", kind="hung", detail="0.2 s"))
    recorder.emit(ContactBegan(t=6.0, agent="R2", other="box", kind="collision"))
    recorder.emit(OutcomeDecided(t=6.0, agent="R2", outcome="success", reason="it stands at the origin"))
    recorder.close(synthetic.summary())
    return recorder.path


def fits(value, schema, where="message"):
    """A small JSON schema validator: types, required keys, and no key that the schema does not know."""
    kinds = {
        "object": dict,
        "array": list,
        "string": str,
        "boolean": bool,
        "integer": int,
        "number": (int, float, type(None)),  # null: the number is not finite, and its bits are in `non_finite`
    }
    assert isinstance(value, kinds[schema["type"]]), where
    if "minimum" in schema:
        assert value >= schema["minimum"], where
    if schema["type"] == "object" and "properties" in schema:
        assert set(schema.get("required", ())) <= set(value), where
        for key, inner in value.items():
            assert key in schema["properties"], f"{where}.{key}"
            if "type" in schema["properties"][key]:
                fits(inner, schema["properties"][key], f"{where}.{key}")
    if schema["type"] == "array" and "items" in schema:
        for i, inner in enumerate(value):
            if "type" in schema["items"]:
                fits(inner, schema["items"], f"{where}[{i}]")


def test_every_channel_is_json_with_an_object_schema_that_its_messages_fit(file):
    summary, found = read(file)
    assert len(found) == len(summary.channels) >= 15
    assert summary.statistics.message_count == sum(len(messages) for _, messages in found.values())
    for topic, (schema, messages) in found.items():
        assert schema.encoding == "jsonschema"
        parsed = json.loads(schema.data)
        assert parsed["type"] == "object", topic
        if topic == "/R2/signals":  # this header declares no signals; see test_named_numbers.py
            del parsed["properties"]["values"]["properties"]
        for _, message in messages[:50]:
            fits(message, parsed, topic)


def test_messages_carry_the_runs_time_and_their_order(file):
    _, found = read(file)
    for topic, (schema, messages) in found.items():
        for message, content in messages:
            assert message.log_time == message.publish_time
            if "t" in content:
                assert message.log_time == round(content["t"] * 1e9)
            if "timestamp" in content:
                stamp = content["timestamp"]
                assert message.log_time == stamp["sec"] * 10**9 + stamp["nsec"]
        if schema.name.startswith("rocs_bt."):
            sequences = [message.sequence for message, _ in messages]
            assert sequences == sorted(set(sequences)), topic


def test_poses_and_frames_are_where_the_bodies_are(file):
    _, found = read(file)
    moved = [e for e in synthetic.events(6.0) if isinstance(e, BodyMoved) and e.body == "R2"]
    schema, poses = found["/R2/pose"]
    assert schema.name == "foxglove.PoseInFrame"
    assert len(poses) == math.ceil(len(moved) / 2)  # ten times a second, of twenty
    for (_, message), event in zip(poses, moved[::2], strict=True):
        at, turn = message["pose"]["position"], message["pose"]["orientation"]
        assert (at["x"], at["y"]) == pytest.approx((event.x, event.y), abs=1e-5)
        assert 2 * math.atan2(turn["z"], turn["w"]) == pytest.approx(event.yaw, abs=1e-5)
        assert message["frame_id"] == "world"
    schema, frames = found["/tf"]
    assert schema.name == "foxglove.FrameTransform"
    assert {m["child_frame_id"] for _, m in frames} == {"R1", "R2"}


def test_a_body_without_wheels_is_shown_at_its_height_with_its_tilt(tmp_path):
    recorder = Recorder(tmp_path / "run.mcap", synthetic.header())
    recorder.emit(BodyMoved(t=0.0, body="R2", x=1.0, y=2.0, yaw=0.5, height=0.75, roll=0.2, pitch=-0.1))
    recorder.close()
    _, found = read(recorder.path)
    for topic, place, orientation in (("/R2/pose", "position", "orientation"), ("/tf", "translation", "rotation")):
        schema, ((_, message),) = found[topic]
        fits(message, json.loads(schema.data))
        pose = message.get("pose", message)
        at, turn = pose[place], pose[orientation]
        shown = Pose3.from_quaternion((at["x"], at["y"], at["z"]), [turn[key] for key in "wxyz"])
        assert shown == pytest.approx((1.0, 2.0, 0.75, 0.2, -0.1, 0.5), abs=1e-6)


def test_beams_end_at_the_echo_in_the_bodys_frame(file):
    _, found = read(file)
    schema, drawn = found["/R2/sonar/beams"]
    assert schema.name == "foxglove.SceneUpdate"
    reads = [e for e in synthetic.events(6.0) if isinstance(e, SensorRead) and e.sensor == "sonar"]
    assert len(drawn) == len(reads) // 2  # ten times a second, of twenty
    for (_, message), event in list(zip(drawn, reads[::2], strict=True))[::10]:
        (entity,) = message["entities"]
        assert entity["frame_id"] == "R2"
        (lines,) = entity["lines"]
        assert lines["type"] == 2
        assert len(lines["points"]) == 32
        for i, distance in enumerate(event.values):
            a, b = lines["points"][2 * i], lines["points"][2 * i + 1]
            assert math.dist((a["x"], a["y"]), (b["x"], b["y"])) == pytest.approx(min(distance, 1.0), abs=2e-3)


def test_a_beam_that_looks_down_is_drawn_downward(tmp_path):
    down = Beam(x=0.1, y=0.0, yaw=0.0, reach=4.0, elevation=-math.pi / 2.0)
    body = BodyInfo(name="R2", hull=(), beams={"below": (down,)}, height=0.2)
    recorder = Recorder(tmp_path / "run.mcap", msgspec.structs.replace(synthetic.header(), bodies=(body,)))
    recorder.emit(SensorRead(t=0.0, agent="R2", sensor="below", stamp=0.0, data=pack([1.5])))
    recorder.close()
    _, found = read(recorder.path)
    (lines,) = found["/R2/below/beams"][1][0][1]["entities"][0]["lines"]
    assert [[p[axis] for axis in "xyz"] for p in lines["points"]] == [[0.1, 0.0, 0.2], [0.1, 0.0, -1.3]]


def test_a_broken_beam_is_not_drawn_and_a_broken_pose_neither(tmp_path):
    recorder = Recorder(tmp_path / "run.mcap", synthetic.header())
    recorder.emit(SensorRead(t=0.0, agent="R2", sensor="sonar", stamp=0.0, data=pack([math.nan] * 16)))
    recorder.emit(SensorRead(t=0.0, agent="R2", sensor="sonar", stamp=0.0, data=pack([1.0] * 3)))
    recorder.emit(BodyMoved(t=0.0, body="R2", x=math.nan, y=0.0, yaw=0.0))
    recorder.emit(BodyMoved(t=0.0, body="R2", x=0.0, y=0.0, yaw=0.0, height=math.inf, roll=0.0, pitch=0.0))
    recorder.close()
    _, found = read(recorder.path)
    assert "/R2/pose" not in found
    (lines,) = found["/R2/sonar/beams"][1][0][1]["entities"][0]["lines"]
    starts, ends = lines["points"][::2], lines["points"][1::2]
    assert all(math.dist((a["x"], a["y"]), (b["x"], b["y"])) < 1e-3 for a, b in zip(starts, ends, strict=True))
    assert len(found["/R2/sensors/sonar"][1]) == 2


def test_the_world_is_drawn_once(file):
    _, found = read(file)
    ((_, scene),) = found["/world/scene"][1]
    names = {entity["id"]: entity for entity in scene["entities"]}
    assert {"wall 0", "box", "post", "origin", "R1/hull", "R2/hull"} <= set(names)
    corners = {(p["x"], p["y"]) for p in names["box"]["lines"][0]["points"]}
    assert corners == {(-0.25, 1.25), (-0.75, 1.25), (-0.75, 0.75), (-0.25, 0.75)}
    assert names["post"]["cylinders"][0]["size"]["x"] == pytest.approx(0.3)
    assert names["R2/hull"]["frame_id"] == "R2"


def test_ground_that_is_not_level_is_drawn_on_the_floor(tmp_path):
    slope = Outline.box("slope", Pose2(1.0, 0.0, 0.0), (2.0, 1.0), 0.2)
    recorder = Recorder(tmp_path / "run.mcap", msgspec.structs.replace(synthetic.header(), grounds=(slope,)))
    recorder.close()
    ((_, scene),) = read(recorder.path)[1]["/world/scene"][1]
    (drawn,) = [entity["lines"] for entity in scene["entities"] if entity["id"] == "slope"]
    assert {(p["x"], p["y"], p["z"]) for line in drawn for p in line["points"]} == {
        (x, y, 0.0) for x in (0.0, 2.0) for y in (-0.5, 0.5)
    }


def test_the_log_tells_firings_failures_and_the_outcome(file):
    _, found = read(file)
    lines = [(m["level"], m["message"]) for _, m in found["/R2/log"][1]]
    assert (4, "sensor sonar failed: no answer") in lines
    assert (5, "block R2/monitor sonar hung: 0.2 s") in lines
    assert (4, "collision with box") in lines
    assert any(level == 3 and "AvoidCollision fired (min(front) = " in text for level, text in lines)
    assert lines[-1] == (2, "outcome: success, it stands at the origin")
