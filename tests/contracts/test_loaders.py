"""Every loader that we ship, with mutated files, random bytes and endless repetitions: a result or a fault."""

from __future__ import annotations

import functools
import re
import signal
from collections.abc import Callable
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from rocs_bt.actions import ACTIONS
from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.errors import InputError, RecordingError, RocsError
from rocs_bt.catalog import Catalog, classes_in, load_robot, make_entry, shipped_root
from rocs_bt.check.stub_agent import stub_agent
from rocs_bt.check.xml_mission import read_palettes
from rocs_bt.devices.mujoco import compose_world
from rocs_bt.event import NullSink
from rocs_bt.expression import Environment
from rocs_bt.knowledge import SCHEMA as KNOWN
from rocs_bt.knowledge import KnowledgeGraph, load_schema
from rocs_bt.knowledge.history import GraphState, from_json_text, to_json_text
from rocs_bt.plan.action_node import action_nodes
from rocs_bt.reactive import load_rules
from rocs_bt.reactive.analysis import examine_rules
from rocs_bt.record import Recorder, Recording
from rocs_bt.search.imports.barn import read_world as read_barn_world
from rocs_bt.search.imports.maps import read_map_yaml, read_pgm
from rocs_bt.testing.missions.substitute import read_rules as read_substitutions
from rocs_bt.trees.nodes import BUILTIN
from rocs_bt.trees.xml import load_xml, palette

from .. import synthetic

SHIPPED = shipped_root()
NODES = BUILTIN.with_([*action_nodes(ACTIONS), *Catalog().load_nodes()])
CPU = 30.0  # [s] that no input of a few kilobytes may take: a bound on work, where a loop or a regular expression hangs
SOAK = 60  # times as many examples


@functools.cache
def environment() -> Environment:
    catalog = Catalog()
    agent = stub_agent(catalog.load_robot("pioneer_p3dx"), catalog.load_class)
    return Environment.of(agent.knowledge.signals)


@functools.cache
def made(folder: Path, kind: str) -> Path:
    """A small file of a binary kind, or of an exported one."""
    path = folder / kind
    if kind == "run.mcap":
        recorder = Recorder(path, synthetic.header())
        for event in synthetic.events(0.4):
            recorder.emit(event)
        recorder.close(synthetic.summary())
        return path
    graph = KnowledgeGraph(SimulatedClock(0.05), NullSink(), "R2")
    for count in range(8):
        graph.add(f"o{count}", "object", radius=1.0)
    path.write_text(to_json_text(GraphState.of(graph)), "utf-8")
    return path


def read_recording(path: Path) -> None:
    recording = Recording.open(path)
    list(recording.events())


def read_robot(path: Path) -> None:
    stub_agent(load_robot(path), Catalog(code=False).load_class)


def examined(path: Path) -> None:
    load_rules(path, environment(), ACTIONS)
    examine_rules(path, environment(), ACTIONS)


SUBSTITUTIONS = '{"TestNodeConfigs": {"Slow": {"async_delay": 2000}}, "SubstitutionRules": {"dock/*": "Slow"}}'
YAML = "image: m.pgm\nresolution: 0.05\norigin: [-1.0, -2.0, 0.0]\nnegate: 0\noccupied_thresh: 0.65\n"
PGM = b"P5\n# a map\n6 4\n255\n" + bytes(range(0, 240, 10))
SCHEMA = 'format = "schema/1"\ndoc = "Chargers."\n[kind.charger]\nextends = "place"\n'
BARN = """<sdf version="1.6"><world name="default"><model name="a"><pose>1 2 0 0 0 0</pose><link name="l">
<collision name="c"><geometry><cylinder><radius>0.1</radius><length>1</length></cylinder></geometry></collision>
</link></model></world></sdf>
"""


@dataclass(frozen=True)
class Loader:
    """A loader of files.

    Attributes:
        read: Reads a file.
        seed: A valid file: its path, its content, or the name of a kind for `made`.
        examples: Mutations in `make test`.
    """

    read: Callable[[Path], object]
    seed: Path | str | bytes
    examples: int = 40


def shipped(name: str) -> Path:
    return SHIPPED / name


LOADERS = {
    "scenario.toml": Loader(lambda path: Catalog().load_scenario(str(path)), shipped("scenarios/exp3.toml"), 150),
    "robot.toml": Loader(read_robot, shipped("robots/pioneer_p3dx/robot.toml"), 150),
    "rules.toml": Loader(examined, shipped("rules/avoid_collision.toml"), 15),
    "planner.toml": Loader(lambda path: Catalog().load_planner(str(path)), shipped("planners/hybrid.toml")),
    "schema.toml": Loader(lambda path: load_schema([path], KNOWN), SCHEMA),
    "world.xml": Loader(lambda path: compose_world(path, []), shipped("scenarios/worlds/arena_box.xml")),
    "robot.xml": Loader(lambda path: compose_world(path, []), shipped("robots/pioneer_p3dx/robot.xml")),
    "mission.xml": Loader(lambda path: load_xml(path, NODES), shipped("planners/missions/dock.xml")),
    "palette.xml": Loader(lambda path: read_palettes([path]), palette(BUILTIN.values())),
    "mission.py": Loader(classes_in, shipped("planners/missions/go_to.py")),
    "run.mcap": Loader(read_recording, "run.mcap"),
    "k.json": Loader(lambda path: from_json_text(path.read_text("utf-8", "replace"), path), "k.json"),
    "substitutions.json": Loader(read_substitutions, SUBSTITUTIONS),
    "map.yaml": Loader(read_map_yaml, YAML),
    "m.pgm": Loader(lambda path: read_pgm(path.read_bytes(), path), PGM),
    "world_0.world": Loader(read_barn_world, BARN),
}
"""Loaders by the name of a file that each reads. `make test` mutates each file a little, `make soak` for long."""

PIECES = [
    "[", "{", "(", "<a>", "<body>", "<!--", "a.", "'a'.", '"', "'''", '"""', "\\", "1", "9", "0.", "-", "not ", "a[0]",
    " ", "\t", "\n", "\r", "#", ",", ";", "=", "&amp;", "&#0;", "]]>", "\0", "\ufeff", "é", "🤖", '{"a":', "nan", "$$",
]  # fmt: skip  # a line for each loader
"""Texts that are repeated: what nests, what a scanner skips, what a number is made of."""

ODD = [
    "nan", "inf", "1e400", "-0", "1e-320", "99999999999999999999", "true", "null", "[]", "{}", "[[]]", '""', '"x"',
    "1979-05-27", "-1",
    '"1e400 m"', '"nan s"', '"0 Hz"', '"5 m5"', '"../../etc/passwd"', '"a.py:C"', '"\\u0000"', '{"a": 1}', "[1, 'a']",
]  # fmt: skip  # short pieces, several on a line


class Mutation(bytes):
    """A mutated file, of which a failing test shows the beginning; the file itself is in its folder."""

    def __repr__(self) -> str:
        return f"{bytes(self[:500])!r} ({len(self)} bytes)"


@st.composite
def mutated(draw: st.DrawFn, seed: bytes) -> Mutation:
    """A file after one to three edits: bytes, lines, values, repetitions; or bytes that have nothing to do with it."""
    if draw(st.integers(0, 9)) == 0:
        return Mutation(draw(st.binary(max_size=200)))
    data = seed
    for _ in range(draw(st.integers(1, 3))):
        kind = draw(st.sampled_from(["cut", "bytes", "drop", "double", "value", "repeat", "splice"]))
        at = draw(st.integers(0, len(data)))
        lines = data.splitlines(keepends=True) or [b""]
        line = draw(st.integers(0, len(lines) - 1))
        if kind == "cut":
            data = data[:at]
        elif kind == "bytes":
            data = data[:at] + draw(st.binary(min_size=1, max_size=6)) + data[at + draw(st.integers(0, 6)) :]
        elif kind == "drop":
            data = b"".join(lines[:line] + lines[line + 1 :])
        elif kind == "double":
            data = b"".join(lines[: line + 1] + lines[line:])
        elif kind == "value":
            found = list(re.finditer(rb'(?<==)\s*("[^"]*"|[^"\n]+)|(?<=: )[^,\n}]+|"[^"]*"|>[^<]+<', data))
            if found:
                old = draw(st.sampled_from(found))
                new = draw(st.sampled_from(ODD)).encode()
                data = data[: old.start()] + new + data[old.end() :]
        elif kind == "repeat":
            piece = draw(st.sampled_from(PIECES)).encode() * draw(st.sampled_from([2, 300, 5000]))
            data = data[:at] + piece + data[at:]
        else:
            begin = draw(st.integers(0, len(data)))
            data = data[:at] + data[begin : begin + draw(st.integers(0, 80))] + data[at:]
    return Mutation(data)


@contextmanager
def bounded():
    """Raises where the processor works for longer than `CPU` on one input, whatever else the machine does."""

    def stop(number: int, frame: object) -> None:
        raise AssertionError(f"one input took more than {CPU:g} s of CPU")

    before = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, CPU)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)


def answered(loader: Loader, path: Path) -> bool:
    """Whether a file was read; a refusal must have a message for a person. All else that is raised fails the test."""
    try:
        with bounded():
            loader.read(path)
    except InputError as error:
        assert error.faults
        assert all(fault.message for fault in error.faults)
        return False
    except RecordingError as error:
        assert str(error)
        return False
    except RocsError as error:
        raise AssertionError(f"no fault of the file is {type(error).__name__}: {error}") from error
    return True


def fuzz(name: str, examples: int, folder: Path, *, derandomize: bool) -> tuple[int, int]:
    """Read mutations of a loader's seed; how many there were, and how many of them were read."""
    loader, counts = LOADERS[name], [0, 0]
    beside = folder / "fuzz"
    beside.mkdir()
    seed = loader.seed
    if isinstance(seed, str) and seed == name:
        seed = made(folder, name)
    data = seed.read_bytes() if isinstance(seed, Path) else seed.encode() if isinstance(seed, str) else seed
    path = beside / name
    if name == "robot.toml":
        (beside / "robot.xml").write_bytes(shipped("robots/pioneer_p3dx/robot.xml").read_bytes())
    path.write_bytes(data)
    assert answered(loader, path), "the seed itself is read"

    @settings(
        max_examples=examples,
        deadline=None,
        derandomize=derandomize,
        database=None,
        phases=[Phase.generate] if derandomize else [Phase.generate, Phase.shrink],
        suppress_health_check=list(HealthCheck),
    )
    @given(mutated(data))
    def holds(mutation: Mutation) -> None:
        path.unlink(missing_ok=True)
        path.write_bytes(mutation)
        counts[0] += 1
        counts[1] += answered(loader, path)
        make_entry(path, "rules", "file")  # its description is read from whatever is there

    holds()
    return counts[0], counts[1]


@pytest.mark.parametrize("name", LOADERS)
def test_whatever_a_file_holds_it_is_read_or_refused(name, tmp_path):
    fuzz(name, LOADERS[name].examples, tmp_path, derandomize=True)


@pytest.mark.soak
@pytest.mark.parametrize("name", LOADERS)
def test_whatever_a_file_holds_it_is_read_or_refused_for_long(name, tmp_path):
    total, read = fuzz(name, SOAK * LOADERS[name].examples, tmp_path, derandomize=False)
    print(f"{name}: {total} files, {read} read, {total - read} refused")


@pytest.mark.parametrize("name", [n for n in LOADERS if n not in ("run.mcap", "rules.toml")])
def test_repetitions_without_end_are_read_or_refused(name, tmp_path):
    path = tmp_path / name
    for piece in PIECES:
        for text in (piece * 20_000, "x = " + piece * 20_000, "<root a='" + piece * 20_000):
            path.write_text(text, "utf-8")
            answered(LOADERS[name], path)
            make_entry(path, "rules", "file")


@pytest.mark.parametrize("groups", ["[nan]", "[[]]", "[1]", "nan", '[{ a = "front" }]'])
def test_groups_that_are_no_names_are_refused_at_their_line(groups, tmp_path):
    folder = shipped("robots/pioneer_p3dx")
    (tmp_path / "robot.xml").write_bytes((folder / "robot.xml").read_bytes())
    text = (folder / "robot.toml").read_text("utf-8")
    path = tmp_path / "robot.toml"
    path.write_text(text.replace('groups = ["front", "rear"]', f"groups = {groups}"), "utf-8")
    line = text[: text.index("groups = [")].count("\n") + 1
    with pytest.raises(InputError) as caught:
        read_robot(path)
    assert [(fault.file, fault.line) for fault in caught.value.faults] == [(path, line)]
