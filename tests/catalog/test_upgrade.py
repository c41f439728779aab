"""Upgrade of old files: the new names, nothing else, and comments stay."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocs_bt.catalog import Catalog, Upgrade, load_robot, read_scenario, upgraded, upgrades
from rocs_bt.catalog.inherit import read_with_base
from rocs_bt.catalog.renamed_keys import FORMATS, ROBOT, SCENARIO
from rocs_bt.errors import InputError

SHIPPED = Catalog(None)

OLD_ROBOT = """\
# A robot.
format = "robot/1" # its format
base = "summit_xl"

[drive]
kind = "skid"
effective_track = "0.9 m"  # [identify]
pivot = "0.05 m"           # [identify]
"max_wheel_speed" = "1 m/s"
wheel_radius = "0.1 m"     # for information

[[sensor]]
name = "robots"            # its driver is that of the base
reach = "1 m"              # fog
'slots' = 2

[[sensor]]
name = "beacon"
driver = "beacon.py:Beacon"
reach = "3 m"              # a key of its own driver

[[sensor]]
name = "gyro"
driver = "gyro"
bias = "0.1 deg/s"

[[monitor]]
name = "range"
memory = "5 s"             # the class, and so the key, is that of the base
[[monitor]]
name = "peers"
slots = 2
[[monitor]]
name = "wheels"
latency = "0.05 s"         # the class is that of the base
deceleration = "1 m/s2"

[[analyze]]
name = "localise"
class = "Localise"
monitors = ["odometry", "pose"]
along = "2 cm"
gyro = 0.1
bias = 0.2
max_age = "0.2 s"
[[analyze]]
name = "turned"
class = "PassOrientation"
step = "10 deg"            # nothing here is renamed

[rules.avoid_collision]
reach = "1 m"              # a threshold of a rule file
track = "1 m"
"""

NEW_ROBOT = """\
# A robot.
format = "robot/3" # its format
base = "summit_xl"

[locomotion]
kind = "skid"
effective_wheel_separation = "0.9 m"  # [identify]
icr_offset = "0.05 m"      # [identify]
"max_wheel_speed" = "1 m/s"
latency = "0.05 s"         # the class is that of the base
deceleration = "1 m/s2"

[[sensor]]
name = "robots"            # its driver is that of the base
max_range = "1 m"          # fog
max_peers = 2

[[sensor]]
name = "beacon"
driver = "beacon.py:Beacon"
reach = "3 m"              # a key of its own driver

[[sensor]]
name = "gyro"
driver = "gyro"
bias_noise = "0.1 deg/s"

[[monitor]]
name = "range"
max_echo_age = "5 s"       # the class, and so the key, is that of the base
[[monitor]]
name = "peers"
max_peers = 2
[[monitor]]
name = "wheels"

[[analyze]]
name = "localise"
class = "Localise"
monitors = ["odometry", "pose"]
travel_noise = "2 cm"
gyro_noise = 0.1
gyro_bias_noise = 0.2
max_age = "0.2 s"
[[analyze]]
name = "turned"
class = "PassOrientation"
step = "10 deg"            # nothing here is renamed

[rules.avoid_collision]
reach = "1 m"              # a threshold of a rule file
track = "1 m"
"""

OLD_SCENARIO = '''\
format = 'scenario/1'
doc = """
[[mover]]  # not a table
at = "1 s"
"""
world = "arena"

[[agent]]
name = "R2"
success = { goal = "g", shortest = "2 m" }  # inline
[[agent]]
name = "R3"
[agent.success] # at = "once"
shortest = "3 m"
[[mover]]
name = "door"
script = "slide"
to_x = "1 m"
  at    = "1 s"     # departure
lasts = "2 s" # short
back_at = "9 s"
yields="1 m"
[mover.jitter]
x = "1 cm"
[[mover]]
name = "R1"
script = "random_walk"
turn_rate = "1 rad/s"
max_bend = "0.2 rad/s"
[[fact]]
node = "box"
at = "12 s"
told_by = [ # two
    { to = "R1", at = 1 }, # at an edge
    { to = "R3" },
]
[[agent.parameters.mover]]
at = 1
'''

NEW_SCENARIO = '''\
format = 'scenario/2'
doc = """
[[mover]]  # not a table
at = "1 s"
"""
world = "arena"

[[agent]]
name = "R2"
success = { goal = "g", shortest_path = "2 m" }  # inline
[[agent]]
name = "R3"
[agent.success] # at = "once"
shortest_path = "3 m"
[[actor]]
name = "door"
script = "slide"
to_x = "1 m"
  depart_at    = "1 s"  # departure
duration = "2 s" # short
return_at = "9 s"
wait_distance="1 m"
[actor.jitter]
x = "1 cm"
[[actor]]
name = "R1"
script = "random_walk"
in_place_turn_rate = "1 rad/s"
max_leg_turn_rate = "0.2 rad/s"
[[fact]]
node = "box"
at = "12 s"
reported_by = [ # two
    { to = "R1", at = 1 }, # at an edge
    { to = "R3" },
]
[[agent.parameters.mover]]
at = 1
'''


def upgrade(text: str, file: Path = Path("scenarios/x.toml"), kind: str = "robot") -> Upgrade:
    return upgraded(text, file, lambda base: SHIPPED.find(kind, base).path)


def test_a_robot_gets_the_new_names_of_its_drivers_and_classes() -> None:
    found = upgrade(OLD_ROBOT, Path("robots/foggy/robot.toml"))
    assert found.text == NEW_ROBOT
    assert [(c.line, c.old, c.new) for c in found.changes][:4] == [
        (2, "robot/1", "robot/3"),
        (5, "drive", "locomotion"),
        (7, "effective_track", "effective_wheel_separation"),
        (8, "pivot", "icr_offset"),
    ]
    (note,) = found.notes
    assert (note.line, note.message) == (20, "'reach' belongs to your own 'beacon.py:Beacon' and stays.")


def test_a_scenario_gets_the_new_names_of_its_scripts_and_tables() -> None:
    assert upgrade(OLD_SCENARIO).text == NEW_SCENARIO


@pytest.mark.parametrize("text", [NEW_ROBOT, NEW_SCENARIO])
def test_a_new_file_stays(text: str) -> None:
    found = upgrade(text)
    assert (found.changes, found.text) == ((), "")


def test_line_ends_stay() -> None:
    crlf = OLD_SCENARIO.replace("\n", "\r\n")
    assert upgrade(crlf).text == NEW_SCENARIO.replace("\n", "\r\n")


@pytest.mark.parametrize("last", ["locomotion", "monitor"])
def test_a_file_may_end_without_a_line_end(last: str) -> None:
    """A key that moves to the last table of the file gets a line of its own."""
    drive = '[drive]\nkind = "differential"\nwheel_separation = "0.3 m"\n'
    monitor = '[[monitor]]\nname = "wheels"\nclass = "WheelMonitor"\nlatency = "0.05 s"\n'
    tables = (monitor, drive) if last == "locomotion" else (drive, monitor)
    text = 'format = "robot/1"\n' + "".join(tables)
    whole, cut = upgrade(text).text, upgrade(text.removesuffix("\n")).text
    assert 'wheel_separation = "0.3 m"\nlatency = "0.05 s"\n' in whole
    assert cut.removesuffix("\n") == whole.removesuffix("\n")


def test_a_new_format_with_an_old_key_is_upgraded_too() -> None:
    mixed = OLD_SCENARIO.replace("scenario/1", "scenario/2")
    assert upgrade(mixed).text == NEW_SCENARIO


def test_a_robots_own_monitor_with_the_name_of_a_shipped_one_keeps_its_keys(tmp_path: Path) -> None:
    (tmp_path / "surround_monitor.py").write_text("class SurroundMonitor: ...\n")
    found = upgrade(OLD_ROBOT, tmp_path / "robot.toml")
    assert 'memory = "5 s"' in found.text
    assert found.text.replace('memory = "5 s"             #', 'max_echo_age = "5 s"       #') == NEW_ROBOT


BARE = st.sampled_from(
    ["name", "reach", "slots", "memory", "bias", "gyro", "at", "track", "mover", "lasts", "x", "cell"]
)
VALUES = st.sampled_from(
    ['"1 m"', "'# at = 1'", "[1, 2]", "true", '"""a\n# b\n"""', "1979-05-27 07:32:00", "0.5", '"\\"#"']
)
PLACES = {
    "robot": [
        "[drive]",
        '[[sensor]]\ndriver = "robot_sensor"',
        '[[sensor]]\ndriver = "gyro"',
        '[[sensor]]\ndriver="a.py:A"',
    ]
    + [f'[[analyze]]\nclass = "{c}"' for c in ("Localise", "LocalMap", "TrackObjects", "PassRange")]
    + [f'[[monitor]]\nclass = "{c}"' for c in ("PeerMonitor", "MessageMonitor", "RangeMonitor")],
    "scenario": ["[rate]", "[[fact]]", "[[agent]]\nsuccess.shortest = 1", '[[mover]]\nscript="slide"', "[[mover]]"],
}


@st.composite
def old_files(draw: st.DrawFn) -> str:
    """Text of a file of an old format: tables with keys, spaces, nested values and comments."""
    kind = draw(st.sampled_from(sorted(PLACES)))
    lines = [f'format = "{kind}/1"']
    names = sorted({key for renamed in FORMATS[f"{kind}/1"].renamed for key in renamed.keys} - {"mover", "drive"})
    for place in draw(st.lists(st.sampled_from(PLACES[kind]), max_size=4).map(_once)):
        head, *first = place.split("\n")
        taken = {line.partition("=")[0].strip() for line in first}
        rows = draw(st.dictionaries(st.sampled_from([*names, "name", "step"]), _one_line(), max_size=5))
        lines += [head + draw(SPACES) + "# table", *first]
        lines += [f"{draw(SPACES)}{key}{draw(SPACES)}={value}" for key, value in rows.items() if key not in taken]
    return "\n".join([*lines, ""])


def _once(places: list[str]) -> list[str]:
    """Tables of which only arrays may repeat."""
    return [place for i, place in enumerate(places) if place.startswith("[[") or place not in places[:i]]


SPACES = st.sampled_from(["", " ", "    "])


def _one_line() -> st.SearchStrategy[str]:
    inline = st.dictionaries(BARE, VALUES, max_size=2).map(
        lambda d: f"{{ {', '.join(f'{k} = {v}' for k, v in d.items())} }}"
    )
    lists = st.lists(st.one_of(VALUES, inline), max_size=2).map(
        lambda rows: "[ # list\n " + ", # next\n ".join(rows) + "\n]"
    )
    return st.tuples(SPACES, st.one_of(VALUES, inline, lists), st.sampled_from(["", " # why", "   # x = 1"])).map(
        "".join
    )


def by_hand(data: dict[str, Any]) -> dict[str, Any]:
    """The expected data, by a walk that knows only one level of tables."""

    form = FORMATS[data["format"]]
    found = {**data, "format": form.name}
    for old, new in (("mover", "actor"), ("drive", "locomotion")):
        if old in found:
            found[new] = found.pop(old)
    for table, value in list(found.items()):
        rows = value if isinstance(value, list) else [value]
        new = [_row(form, table, row) if isinstance(row, dict) else row for row in rows]
        found[table] = new if isinstance(value, list) else new[0]
    return found


def _row(form: Any, table: str, row: dict[str, Any]) -> dict[str, Any]:
    row = dict(row)
    for renamed in form.renamed:
        if renamed.table[:1] != (table,):
            continue
        if renamed.where is not None and row.get(renamed.where[0]) != renamed.where[1]:
            continue
        inner = row if len(renamed.table) == 1 else row.get(renamed.table[1], {})
        for old in [old for old in renamed.keys if isinstance(inner, dict) and old in inner]:
            inner[renamed.keys[old]] = inner.pop(old)
    return row


def comments(text: str) -> list[str]:
    """Comments of a text whose strings contain no quotes before a '#'."""
    bare = re.sub(r'"""(.|\n)*?"""|"(\\.|[^"\\\n])*"|\'[^\'\n]*\'', "S", text)
    return re.findall("#.*", bare)


@given(old_files())
def test_any_file_is_renamed_by_the_table_and_keeps_its_comments(text: str) -> None:
    found = upgrade(text)
    assert tomllib.loads(found.text) == by_hand(tomllib.loads(text))
    assert comments(found.text) == comments(text)
    assert not upgrade(found.text).changes


@pytest.mark.parametrize("form", [ROBOT, SCENARIO])
def test_no_new_name_is_an_old_name_of_the_same_table(form: Any) -> None:
    for renamed in form.renamed:
        assert not set(renamed.keys) & set(renamed.keys.values())


@pytest.mark.parametrize(
    ("text", "line", "message"),
    [
        ('format = "robot/1"\n[drive]\ntrack = 1\nwheel_separation = 1\n', 3, "the table has both"),
        ('format = "robot/1"\n[drive\n', 2, "not valid TOML"),
        ('format = "robot/1"\nbase = "none_such"\n', 2, "no robot is named 'none_such'"),
        ('format = "schema/1"\n', 0, "no format that can be upgraded"),
        ('format = "robot/1"\n[drive]\n"\\u0074rack" = 1\n', 0, "cannot be rewritten by names alone"),
        ('format = "robot\\u002f1"\n', 0, "cannot be rewritten by names alone"),
        ('"\\u0066ormat" = "robot/1"\n', 0, "cannot be rewritten by names alone"),
        ("", 0, "no format that can be upgraded"),
    ],
)
def test_what_cannot_be_upgraded_is_an_error_with_its_position(text: str, line: int, message: str) -> None:
    with pytest.raises(InputError) as caught:
        upgrade(text)
    (fault,) = caught.value.faults
    assert message in fault.message
    assert fault.line == line


def test_the_old_format_is_refused_with_the_command(tmp_path: Path) -> None:
    file = tmp_path / "robot.toml"
    file.write_text(OLD_ROBOT)
    with pytest.raises(InputError) as caught:
        load_robot(file, lambda base: SHIPPED.find("robot", base).path)
    (fault,) = caught.value.faults
    assert (fault.line, fault.column) == (2, 1)
    assert fault.message == "the format 'robot/1' is old; the present one is 'robot/3'."
    assert fault.hint == f"`rocs-bt upgrade {file}` rewrites the file."


def test_an_old_key_is_refused_with_its_new_name(tmp_path: Path) -> None:
    file = tmp_path / "x.toml"
    file.write_text(OLD_SCENARIO.replace("scenario/1", "scenario/2"))
    with pytest.raises(InputError) as caught:
        read_scenario(read_with_base(file))
    found = {(f.line, f.message) for f in caught.value.faults}
    assert (15, "the key 'mover' is called 'actor' since scenario/2.") in found
    assert (19, "the key 'at' is called 'depart_at' since scenario/2.") in found
    assert (33, "the key 'told_by' is called 'reported_by' since scenario/2.") in found
    assert all(f.hint == f"`rocs-bt upgrade {file}` rewrites the file." for f in caught.value.faults)


def test_an_old_base_is_refused_at_its_own_line(tmp_path: Path) -> None:
    (tmp_path / "old.toml").write_text(OLD_SCENARIO)
    (tmp_path / "x.toml").write_text('format = "scenario/2"\nbase = "old"\n')
    with pytest.raises(InputError) as caught:
        read_with_base(tmp_path / "x.toml", lambda base: tmp_path / f"{base}.toml")
    (fault,) = caught.value.faults
    assert (fault.file, fault.line) == (tmp_path / "old.toml", 1)


def test_an_old_file_on_an_old_base_is_upgraded_by_what_the_base_says(tmp_path: Path) -> None:
    for root, file in ((tmp_path / "scenarios", "old.toml"), (tmp_path / "scenarios", "x.toml")):
        root.mkdir(exist_ok=True)
        (root / file).write_text(OLD_SCENARIO)
    own = 'format = "scenario/1"\nbase = "old"\n[[mover]]\nname = "door"\nat = "3 s"\n[[mover]]\nname = "R1"\nat = 1\n'
    (tmp_path / "scenarios/x.toml").write_text(own)
    found = {u.file.name: u for u in upgrades(tmp_path)}
    assert found["old.toml"].text == NEW_SCENARIO
    assert found["x.toml"].text == (
        'format = "scenario/2"\nbase = "old"\n[[actor]]\nname = "door"\ndepart_at = "3 s"\n'
        '[[actor]]\nname = "R1"\nat = 1\n'
    )


def test_the_page_lists_every_renamed_key() -> None:
    page = (Path(__file__).resolve().parents[2] / "docs/files.md").read_text("utf-8")
    section = page.partition("## Upgrade old files")[2].partition("\n## ")[0]
    listed, form, table = set(), "", ""
    for row in (line.split("|")[1:-1] for line in section.splitlines() if line.startswith("| ")):
        form, table = row[0].strip() or form, row[1].strip() or ("" if row[0].strip() else table)
        pairs = zip(*(re.findall(r"`\[*(\w+)\]*`", cell) for cell in row[2:4]), strict=True)
        listed |= {(form.strip("`"), *pair) for pair in pairs}
    wanted = {(f.name, old, new) for f in (ROBOT, SCENARIO) for r in f.renamed for old, new in r.keys.items()}
    assert listed == wanted
