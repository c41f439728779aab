"""What is written is read back: exactly, after any cut, and never silently wrong."""

import math
import re
import struct
import subprocess
import sys
import textwrap
import threading
import tracemalloc
from collections.abc import Mapping
from pathlib import Path
from types import SimpleNamespace

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader
from mcap.writer import CompressionType

import rocs_bt.event as ev
from rocs_bt.base.errors import RecordingError
from rocs_bt.event import Event, ListSink, SensorRead, TicketChanged, pack
from rocs_bt.record.file import codec
from rocs_bt.record.file.recorder import Recorder
from rocs_bt.record.file.recording import Recording
from rocs_bt.record.fold.arrays import event_table

from .. import synthetic


def write(path: Path, events, summary=None) -> Path:
    recorder = Recorder(path, synthetic.header())
    for event in events:
        recorder.emit(event)
    recorder.close(summary)
    return path


def same(a: Event, b: Event) -> bool:
    """Equality in which NaN equals NaN."""
    return msgspec.msgpack.encode(a, order="sorted") == msgspec.msgpack.encode(b, order="sorted")


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    path = tmp_path_factory.mktemp("run") / "run.mcap"
    return write(path, synthetic.events(6.0), synthetic.summary())


def test_a_recording_without_compression_is_read_too(tmp_path, run, monkeypatch):
    """As versions before lz4 wrote them."""
    monkeypatch.setattr("rocs_bt.record.file.recorder.CompressionType", SimpleNamespace(LZ4=CompressionType.NONE))
    plain = write(tmp_path / "run.mcap", synthetic.events(6.0), synthetic.summary())
    assert plain.stat().st_size > 2 * run.stat().st_size
    old, new = Recording.open(plain), Recording.open(run)
    assert all(same(a, b) for a, b in zip(old.events(), new.events(), strict=True))
    assert old.summary == new.summary


def test_every_kind_of_event_has_a_topic_of_its_own():
    assert len({codec.topic_of(kind, "R2") for kind in codec.KINDS}) == len(codec.KINDS) >= 15
    assert codec.topic_of(ev.TicketChanged, "R2") == "/R2/tickets"
    assert codec.topic_of(ev.BodyMoved, "") == "/world/poses"


number = st.floats(allow_nan=True, allow_infinity=True)
text = st.text(st.characters(exclude_categories=("Cs",)), max_size=12)
value = st.one_of(number, st.integers(-(2**53), 2**53), text, st.booleans(), st.none(), st.lists(number, max_size=3))
fields = {float: number, str: text, int: st.integers(-(2**31), 2**31), bytes: st.binary(max_size=40)}
fields[float | None] = st.one_of(number, st.none())
fields[tuple[float, ...]] = st.lists(number, max_size=3).map(tuple)
fields[tuple[float, float, float]] = st.tuples(number, number, number)
fields[bool] = st.booleans()
fields[tuple[tuple[float, float], ...]] = st.lists(st.tuples(number, number), max_size=3).map(tuple)
cells = st.tuples(st.integers(-(2**31), 2**31), st.integers(-(2**31), 2**31))
fields[tuple[tuple[int, int], ...]] = st.lists(cells, max_size=3).map(tuple)
keys = st.dictionaries(text, text, max_size=2)
nodes = st.builds(ev.TreeNode, path=text, type=text, children=st.just(("a", "b")), ports=text, board=text, keys=keys)
fields[tuple[ev.TreeNode, ...]] = st.lists(nodes, max_size=3).map(tuple)
fields[tuple[ev.GuardInfo, ...]] = st.lists(
    st.builds(ev.GuardInfo, rule=text, when=text, until=text, priority=st.integers(-9, 9), hold=number), max_size=2
).map(tuple)
fields[Mapping[str, str]] = st.dictionaries(text, text, max_size=3)


@st.composite
def any_event(draw) -> Event:
    kind = draw(st.sampled_from(codec.KINDS))
    values = {}
    for field in msgspec.structs.fields(kind):
        if field.name in ("values", "parameters", "attributes"):
            values[field.name] = draw(st.dictionaries(text, value, max_size=3))
        elif field.name == "value" and field.type is not str:
            values[field.name] = draw(value)
        elif field.name == "signals":
            values[field.name] = tuple(draw(st.lists(text, max_size=3)))
        elif field.name == "sizes":
            values[field.name] = tuple(draw(st.lists(st.integers(0, 9), max_size=3)))
        elif field.name == "t":
            values["t"] = draw(st.floats(0.0, 1e6))
        else:
            values[field.name] = draw(fields[field.type])
    return kind(**values)


@settings(max_examples=300)
@given(any_event())
def test_json_gives_back_the_very_event(event):
    data = codec.encode(event)
    msgspec.json.decode(data)  # plain JSON, for others
    assert same(codec.decode(data), event)


def test_a_body_on_wheels_is_recorded_without_height_and_an_old_recording_of_it_is_read():
    moved = ev.BodyMoved(t=0.5, agent="R2", body="R2", x=1.0, y=2.0, yaw=0.5, wheels=b"12345678")
    data = b'{"event":"BodyMoved","t":0.5,"agent":"R2","body":"R2","x":1.0,"y":2.0,"yaw":0.5,"wheels":"MTIzNDU2Nzg="}'
    assert codec.encode(moved) == data
    assert codec.decode(data) == moved
    box = ev.BodyMoved(t=0.5, body="box", x=1.0, y=2.0, yaw=0.5)
    assert codec.encode(box).endswith(b'"agent":"","body":"box","x":1.0,"y":2.0,"yaw":0.5,"wheels":""}')


def test_even_the_sign_of_a_nan_comes_back():
    event = ev.FollowerStepped(t=0.0, cross_track=-math.nan, heading_error=-math.inf, rung="")
    back = codec.decode(codec.encode(event))
    assert math.copysign(1.0, back.cross_track) == -1.0
    assert back.heading_error == -math.inf


@settings(max_examples=20, deadline=None)
@given(st.lists(any_event(), max_size=30))
def test_a_file_gives_back_all_events_in_their_order(tmp_path_factory, events):
    path = write(tmp_path_factory.mktemp("round") / "run.mcap", events)
    back = list(Recording.open(path).events())
    assert len(back) == len(events)
    assert all(same(a, b) for a, b in zip(back, events, strict=True))


def test_a_whole_run_comes_back_with_header_and_summary(run):
    recording = Recording.open(run)
    assert recording.complete
    assert recording.header == synthetic.header()
    assert recording.summary == synthetic.summary()
    assert list(recording.events()) == synthetic.events(6.0)
    assert list(recording.events()) == list(recording.events())
    assert Recording.open(run.parent).header == recording.header  # the run's folder will do


def test_same_events_same_bytes(run, tmp_path):
    again = write(tmp_path / "again.mcap", synthetic.events(6.0), synthetic.summary())
    assert again.read_bytes() == run.read_bytes()


def test_numbers_of_numpy_are_recorded_as_numbers(tmp_path):
    event = TicketChanged(
        t=0.0,
        agent="R2",
        ticket=1,
        action="GoTo",
        priority="NORMAL",
        state="QUEUED",
        by="root",
        parameters={"speed": np.float64(0.1) + np.float32(0), "n": np.int64(3), "gap": np.float64(math.inf)},
    )
    (back,) = Recording.open(write(tmp_path / "run.mcap", [event])).events()
    assert back.parameters == {"speed": 0.1, "n": 3, "gap": math.inf}


def test_cut_anywhere_it_is_read_up_to_the_cut_or_refused(run, tmp_path):
    data, events = run.read_bytes(), synthetic.events(6.0)
    begin = data.index(b"/world/scene")  # behind the header
    rng = np.random.default_rng(1)
    cuts = [*range(40), *range(len(data) - 40, len(data)), *rng.integers(begin, len(data), 150).tolist()]
    seen = []
    for cut in cuts:
        path = tmp_path / "cut.mcap"
        path.write_bytes(data[:cut])
        try:
            recording = Recording.open(path)
        except RecordingError as error:
            assert cut < begin, error
            assert "cut.mcap" in str(error)
            continue
        found = list(recording.events())
        assert not recording.complete
        assert found == events[: len(found)]
        seen.append((cut, len(found)))
    counts = [n for _, n in sorted(seen)]
    assert counts == sorted(counts)
    assert counts[-1] == len(events)


@pytest.mark.parametrize(
    ("content", "says"),
    [(b"", "empty"), (b"hello world", "begins with"), (b"\x89MCAP0\r\n", "cut off within")],
)
def test_what_is_no_recording_is_refused(tmp_path, content, says):
    path = tmp_path / "x.mcap"
    path.write_bytes(content)
    with pytest.raises(RecordingError, match=says):
        Recording.open(path)


def test_a_missing_file_is_refused_with_those_that_there_are(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for run in ("runs/exp1-1", "mine/exp3-2"):
        (tmp_path / run).mkdir(parents=True)
        (tmp_path / run / "run.mcap").touch()
    with pytest.raises(RecordingError, match=r"named 'mine/exp3-1'\. Did you mean 'mine/exp3-2'\?") as told:
        Recording.open(Path("mine/exp3-1"))
    assert "runs/exp1-1" in str(told.value)
    with pytest.raises(RecordingError, match=r"no recording is named 'runs'.*runs/exp1-1"):
        Recording.open(Path("runs"))


def test_another_programs_mcap_is_refused(tmp_path):
    from mcap.writer import CompressionType, Writer

    path = tmp_path / "other.mcap"
    writer = Writer(str(path), compression=CompressionType.NONE)
    writer.start()
    writer.add_message(writer.register_channel("a", "json", 0), 0, b"{}", 0)
    writer.finish()
    with pytest.raises(RecordingError, match="not written by rocs_bt"):
        Recording.open(path)


def test_a_later_format_is_refused(run, tmp_path):
    path = tmp_path / "later.mcap"
    path.write_bytes(run.read_bytes().replace(b"format\x01\0\0\x001", b"format\x01\0\0\x009"))
    with pytest.raises(RecordingError, match="format 9; this version of rocs_bt reads format 1"):
        Recording.open(path)


def test_damaged_anywhere_it_is_read_up_to_the_damage_or_refused(run, tmp_path):
    data, events = run.read_bytes(), synthetic.events(6.0)
    begin = data.index(b"/world/scene")  # behind the header
    path, rng, read = tmp_path / "damaged.mcap", np.random.default_rng(2), []
    for at in sorted(rng.integers(8, len(data), 150).tolist()):
        broken = bytearray(data)
        broken[at] ^= 1 << int(rng.integers(8))
        path.write_bytes(broken)
        try:
            recording = Recording.open(path)
        except RecordingError as error:
            assert at < begin, error
            assert str(path) in str(error)
            continue
        found = list(recording.events())
        assert found == events[: len(found)]
        if len(found) < len(events):
            assert not recording.complete
            assert re.fullmatch(rf".*'{path}' .*; it is read up to t = \d\.\d\d s\.", recording.missing)
            assert float(recording.missing.split()[-2]) == pytest.approx(found[-1].t if found else 0.0, abs=0.01)
            read.append(len(found))
    assert read == sorted(read)
    assert len(set(read)) > 5


def test_a_writer_killed_at_any_moment_leaves_all_but_the_last_half_second(tmp_path):
    script = textwrap.dedent("""
        import mmap, os, random, signal, struct, sys, time
        from pathlib import Path
        from rocs_bt.event import SensorRead, pack
        from rocs_bt.record.file.header import RunHeader
        from rocs_bt.record.file.recorder import Recorder

        for k in range(30):
            emitted = mmap.mmap(-1, 8)
            process = os.fork()
            if not process:
                recorder = Recorder(Path(f"{sys.argv[1]}/{k}.mcap"), RunHeader(scenario="killed", seed=1))
                for i in range(1, 1 << 30):
                    data = pack([i / 7.0 + j for j in range(40)])
                    recorder.emit(SensorRead(t=i * 0.05, agent="R2", sensor="s", stamp=i * 0.05, data=data))
                    emitted[:] = struct.pack("q", i)
            while not any(emitted[:]):
                time.sleep(0.0001)
            time.sleep(random.Random(k).uniform(0.0, 0.05))
            os.kill(process, signal.SIGKILL)
            os.waitpid(process, 0)
            print(*struct.unpack("q", emitted[:]))
    """)
    ran = subprocess.run([sys.executable, "-c", script, str(tmp_path)], check=True, capture_output=True, text=True)
    for k, last in enumerate(map(int, ran.stdout.split())):
        recording = Recording.open(tmp_path / f"{k}.mcap")
        found = list(recording.events())
        assert not recording.complete
        assert recording.summary is None
        assert [round(e.t / 0.05) for e in found] == list(range(1, len(found) + 1))
        assert len(found) >= last - 11


def test_an_event_that_is_not_data_is_told_at_the_end_and_the_rest_is_kept(tmp_path):
    good = synthetic.events(0.5)
    bad = TicketChanged(
        t=0.1, agent="R2", ticket=1, action="A", priority="HIGH", state="QUEUED", by="x", parameters={"p": object()}
    )
    recorder = Recorder(tmp_path / "run.mcap", synthetic.header())
    for event in [bad, *good, SensorRead(t=math.nan, sensor="s", stamp=0.0, data=b"")]:
        recorder.emit(event)
    with pytest.raises(
        RecordingError, match=r"2 events could not be recorded in .*; the first: TicketChanged at t = 0\.1 s"
    ):
        recorder.close(synthetic.summary())
    recording = Recording.open(tmp_path / "run.mcap")
    assert recording.complete
    assert list(recording.events()) == good


def test_nothing_is_taken_after_the_end(tmp_path):
    recorder = Recorder(tmp_path / "run.mcap", synthetic.header())
    recorder.close()
    recorder.emit(synthetic.events(0.1)[0])
    recorder.close()
    assert list(Recording.open(recorder.path).events()) == []


def test_threads_may_emit_at_once(tmp_path):
    recorder = Recorder(tmp_path / "run.mcap", synthetic.header())

    def emit(agent: str) -> None:
        for k in range(500):
            recorder.emit(SensorRead(t=k * 0.01, agent=agent, sensor="s", stamp=k * 0.01, data=pack([k])))

    threads = [threading.Thread(target=emit, args=(f"R{i}",)) for i in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    recorder.close()
    found = list(Recording.open(recorder.path).events())
    for i in range(4):
        mine = [e.values[0] for e in found if e.agent == f"R{i}"]
        assert mine == [float(k) for k in range(500)]


def test_kinds_that_a_user_adds_are_written_and_skipped(tmp_path):
    class Sang(Event, frozen=True, kw_only=True):
        song: str

    sink = ListSink()
    sink.emit(Sang(t=0.0, agent="R2", song="la"))
    sink.emit(SensorRead(t=0.0, agent="R2", sensor="s", stamp=0.0, data=b""))
    path = write(tmp_path / "run.mcap", sink.events)
    with path.open("rb") as file:  # as any other program reads it
        messages = {channel.topic: message.data for _, channel, message in make_reader(file).iter_messages()}
    assert msgspec.json.decode(messages["/R2/Sang"])["song"] == "la"
    assert list(Recording.open(path).events()) == sink.events[1:]


def test_a_recording_is_opened_by_text_or_path(recording):
    for path in (recording.path, recording.path.parent, str(recording.path), str(recording.path.parent)):
        assert Recording.open(path).header == recording.header
    with pytest.raises(RecordingError, match="no recording is named 'text'"):
        Recording.open("text")


@pytest.mark.parametrize("opcode", [0x06, 0x09, 0x0C], ids=["chunk", "attachment", "metadata"])
@pytest.mark.parametrize(
    "body", [b"", b"\xff" * 3, b"\x02\0\0\0\xff\xfe", b"\xff" * 40], ids=["empty", "short", "no text", "long"]
)
def test_records_that_cannot_be_read_are_damage(run, tmp_path, opcode, body):
    data, magic = run.read_bytes(), 8
    path = tmp_path / "damaged.mcap"
    path.write_bytes(data[:magic] + struct.pack("<BQ", opcode, len(body)) + body + data[magic:])
    try:
        list(Recording.open(path).events())
    except RecordingError as error:
        assert "damaged" in str(error) or "compressed" in str(error)


def test_a_long_run_never_is_in_memory_as_a_whole(tmp_path):
    recorder, rng = Recorder(tmp_path / "run.mcap", synthetic.header()), np.random.default_rng(1)
    for k in range(1500):
        data = pack(rng.uniform(0.0, 9.0, 720))
        recorder.emit(SensorRead(t=0.05 * k, agent="R2", sensor="lidar", stamp=0.05 * k, data=data))
    recorder.close()
    size = recorder.path.stat().st_size
    assert size > 8_000_000
    tracemalloc.start()
    try:
        recording = Recording.open(recorder.path)
        assert sum(1 for _ in recording.events()) == 1500
        assert len(event_table(recording)) == 1500
        assert tracemalloc.get_traced_memory()[1] < 0.6 * size
    finally:
        tracemalloc.stop()
