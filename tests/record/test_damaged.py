"""Recordings with one damaged value: each command that reads them gives a result or a clear error, and ends."""

from __future__ import annotations

import io
import json
import random
import re
import shutil
import struct
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import click
import pytest
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer

from rocs_bt.cli.main import call, group

VALUES: list[Any] = [
    *(
        None,
        "x",
        "",
        0,
        -1,
        -5,
        590,
        1e6,
        1e9,
        1e300,
        2**53,
        10**30,
        1e-320,
        float("nan"),
        True,
        [],
        {},
        [1.0, 2.0, 3.0],
    ),
    *({"a": 1}, "9" * 400, "/etc", "a\0b", ...),  # `...`: no value
]
COMMANDS = [
    "report d --out o",
    "replay d --why 1",
    "replay d",
    "export d --rosbag o",
    "requirements d",
    "rules replay avoid_collision d --out o",
    "knowledge show d --format text",
    "knowledge query d robot",
    "knowledge why d",
    "knowledge export d",
    "plot d --out o",
    "rules tune avoid_collision d --rule Flinch --threshold flinch_clear --steps 3 --out o",
]
Keys = tuple[Any, ...]
pytestmark = pytest.mark.filterwarnings("ignore:Glyph")  # of a name in a figure


class Damaged:
    """Writer of copies of a recording, in which one value of an event, the header or the summary is replaced."""

    def __init__(self, recording: bytes) -> None:
        reader = make_reader(io.BytesIO(recording))
        self.messages = list(reader.iter_messages(log_time_order=False))
        self.attachments = list(reader.iter_attachments())
        self.metadata = list(reader.iter_metadata())
        self.places: dict[tuple[str, Keys], list[tuple[int | str, Keys]]] = {}
        for index, (schema, _, message) in enumerate(self.messages):
            if schema is not None and schema.name.startswith("rocs_bt."):
                self._add(schema.name, index, message.data)
        for attachment in self.attachments:
            self._add(attachment.name, attachment.name, attachment.data)

    def _add(self, kind: str, owner: int | str, data: bytes) -> None:
        for path in paths(json.loads(data)):
            alike = kind, tuple(each if isinstance(each, str) else "#" for each in path)
            self.places.setdefault(alike, []).append((owner, path))

    def write(self, file: Path, owner: int | str, path: Keys, value: Any) -> None:
        """Write a copy in which the value at a path of a message or an attachment is replaced."""
        attached = {a.name: replaced(a.data, path, value) if a.name == owner else a.data for a in self.attachments}
        with file.open("wb") as opened:
            writer = Writer(opened, compression=CompressionType.LZ4)
            writer.start(library="rocs_bt")
            for each in self.metadata:
                writer.add_metadata(each.name, each.metadata)
            writer.add_attachment(0, 0, "header.json", "application/json", attached.pop("header.json"))
            schemas: dict[int, int] = {}
            channels: dict[int, int] = {}
            for index, (schema, channel, message) in enumerate(self.messages):
                assert schema is not None
                if channel.id not in channels:
                    if schema.id not in schemas:
                        schemas[schema.id] = writer.register_schema(schema.name, schema.encoding, schema.data)
                    channels[channel.id] = writer.register_channel(channel.topic, "json", schemas[schema.id])
                data = replaced(message.data, path, value) if index == owner else message.data
                writer.add_message(channels[channel.id], message.log_time, data, message.publish_time)
            for name, data in attached.items():
                writer.add_attachment(0, 0, name, "application/json", data)
            writer.finish()


def paths(value: Any, at: Keys = ()) -> Iterator[Keys]:
    """Paths of all values in a JSON document; of lists the first two."""
    inner = value.items() if isinstance(value, dict) else enumerate(value[:2]) if isinstance(value, list) else ()
    for key, each in inner:
        yield (*at, key)
        yield from paths(each, (*at, key))


def replaced(data: bytes, path: Keys, value: Any) -> bytes:
    document = json.loads(data)
    *outer, last = path
    at = document
    for key in outer:
        at = at[key]
    if value is ...:
        del at[last]
    else:
        at[last] = value
    return json.dumps(document).encode()


@pytest.fixture(scope="module")
def damaged(tmp_path_factory: pytest.TempPathFactory) -> Damaged:
    out = tmp_path_factory.mktemp("run")
    assert call(["run", "exp1", "--for", "0.6", "--out", str(out), "--no-report"]) == 1
    return Damaged((out / "run.mcap").read_bytes())


@pytest.fixture
def read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Callable[..., None]:
    monkeypatch.chdir(tmp_path)

    def read(line: str, what: object) -> None:
        code, err = call(line.split()), capsys.readouterr().err
        assert code in (0, 1, 2), f"{what} {line}\n{err[-2000:]}"
        assert "Traceback" not in err, f"{what} {line}\n{err[-2000:]}"
        assert code != 2 or err.strip(), f"{what} {line}"
        assert sum(file.stat().st_size for file in tmp_path.rglob("*")) < 30e6, f"{what} {line}"

    return read


def campaign(damaged: Damaged, read: Callable[..., None], tmp_path: Path, seed: int, trials: int) -> None:
    rng = random.Random(seed)
    places = list(damaged.places.values())
    for trial in range(trials):
        owner, path = rng.choice(rng.choice(places))
        value, line = rng.choice(VALUES), rng.choice(COMMANDS)
        folder = tmp_path / str(trial)
        folder.mkdir()
        damaged.write(folder / "run.mcap", owner, path, value)
        read(line.replace(" d", f" {folder}").replace(" o", f" {folder}/out"), (owner, path, value))


def test_a_damaged_value_is_a_clear_error_or_harmless(damaged, read, tmp_path):
    campaign(damaged, read, tmp_path, seed=1, trials=24)


@pytest.mark.soak
@pytest.mark.parametrize("seed", range(2, 12))
def test_many_damaged_values(damaged, read, tmp_path, seed):
    campaign(damaged, read, tmp_path, seed, trials=150)


@pytest.mark.parametrize(
    "value",
    [{"sensor": "sonar", "first": 0, "count": 8}, {"sensor": "?", "first": -8, "count": 2**40}, "AAAA", [{}], ...],
)
def test_signals_that_do_not_fit_are_damage(damaged, tmp_path, capsys, monkeypatch, value):
    monkeypatch.chdir(tmp_path)
    owner = next(o for (kind, _), found in damaged.places.items() if "SignalsWritten" in kind for o, _ in found)
    damaged.write(tmp_path / "run.mcap", owner, ("values", "sonar"), value)
    for line in ("knowledge query run.mcap robot", "rules replay avoid_collision run.mcap"):
        assert call(line.split()) == 0
        assert re.search(r"'run.mcap' is damaged: .*; it is read up to t = 0\.00 s\.$", capsys.readouterr().err.strip())


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        (("start",), 2**53, "the run starts at 9.0072e+15 s"),
        (("start",), -5, "the run starts at -5 s"),
        (("rates", "control"), -1, "control: -1 Hz"),
        (("places", 0, "x"), 1e300, "it has the number 1e+300"),
        (("agents", 0, "signals", 0, "high"), -5, "signal 'sonar' has the bounds 0 and -5"),
        (("agents", 0, "signals", 0, "size"), 10**12, "it has the number 1e+12"),
    ],
)
def test_a_header_that_cannot_be_is_refused(damaged, tmp_path, capsys, monkeypatch, path, value, message):
    monkeypatch.chdir(tmp_path)
    damaged.write(tmp_path / "run.mcap", "header.json", path, value)
    for line in COMMANDS:
        assert call(line.replace(" d", " run.mcap").split()) == 2
        assert message in capsys.readouterr().err
    assert [file.name for file in tmp_path.iterdir()] == ["run.mcap"]


def test_a_bag_cannot_begin_or_end_after_what_time_stamps_hold(damaged, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    damaged.write(tmp_path / "run.mcap", "", (), None)
    for start, message in (("5000000000", "must be 0 to 2147483647"), ("2147483647", "Use an earlier --start")):
        assert call(["export", "run.mcap", "--rosbag", "bag", "--start", start]) == 2
        assert message in capsys.readouterr().err
        assert not (tmp_path / "bag").exists()


def commands(within: click.Group, *names: str) -> Iterator[tuple[str, click.Command]]:
    """Names and objects of all commands, also of groups."""
    for name in within.list_commands(click.Context(within)):
        command = within.get_command(click.Context(within), name)
        if isinstance(command, click.Group):
            yield from commands(command, *names, name)
        elif command is not None:
            yield " ".join([*names, name]), command


def test_all_commands_that_read_recordings_are_tried():
    reads = {
        name
        for name, each in commands(group)
        if any(isinstance(p, click.Argument) and p.name in ("run", "runs") for p in each.params)
    }
    tried = {name for name in reads if any(line.startswith(name) for line in COMMANDS)}
    assert reads == tried


@pytest.fixture(scope="module")
def long(tmp_path_factory: pytest.TempPathFactory) -> tuple[bytes, list[int]]:
    """A run, and the places of its chunks."""
    out = tmp_path_factory.mktemp("run")
    assert call(["run", "exp1", "--for", "3", "--out", str(out), "--no-report"]) == 1
    data = (out / "run.mcap").read_bytes()
    at, found = 8, []
    while data[at] != 2:  # the footer
        if data[at] == 6:
            found.append(at)
        at += 9 + struct.unpack_from("<Q", data, at + 1)[0]
    return data, found


@pytest.mark.parametrize("line", COMMANDS)
@pytest.mark.parametrize("count", range(3))
def test_a_recording_of_little_or_nothing_is_read(long, line, count, tmp_path, read):
    data, chunks = long
    (tmp_path / "run.mcap").write_bytes(data[: chunks[count]])
    read(line.replace(" d", " run.mcap"), count)


@pytest.mark.parametrize("line", COMMANDS)
def test_a_damaged_chunk_is_read_up_to_as_if_it_was_cut_off_there(long, line, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    data, chunks = long
    assert len(chunks) > 6
    broken = bytearray(data)
    broken[chunks[5] + 200] ^= 0x10
    (folder := tmp_path / "d").mkdir()
    told = []
    for content in (data[: chunks[5] + 50], bytes(broken)):
        (folder / "run.mcap").write_bytes(content)
        told.append((call(line.replace(" d", f" {folder}").split()), *capsys.readouterr()))
        shutil.rmtree("o", ignore_errors=True)
    (code, out, err), (damaged_code, damaged_out, damaged_err) = told
    assert (damaged_code, damaged_out) == (code, out)
    (end,) = re.findall(rf"the recording '{folder}/run.mcap' was cut off; it is read up to t = (\d\.\d\d) s\.\n", err)
    assert 1.0 < float(end) < 2.0
    fault = f"'{folder}/run.mcap' is damaged: the chunk at byte {chunks[5]} has a wrong size or checksum"
    assert damaged_err.count(f"{fault}; it is read up to t = {end} s.\n") == 1
