"""Rule files with any TOML value at any key: they are refused with faults or they load, and nothing else is raised."""

import time

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rocs_bt.base.errors import Fault, InputError
from rocs_bt.cli.main import call
from rocs_bt.reactive import load_rules
from rocs_bt.reactive.analysis import examine_rules

from .examined import ACTIONS, ENVIRONMENT

SOUND = {
    "format": '"reflex/1"',
    "threshold.near": '"0.4 m"',
    "alias.close": '"min(front) < near"',
    "rule.A.when": '"close and speed > 0 m/s"',
    "rule.A.until": '"min(front) > 0.5 m"',
    "rule.A.for": '"0.1 s"',
    "rule.A.cooldown": '"0.5 s"',
    "rule.A.trigger": '"edge"',
    "rule.A.priority": "5",
    "rule.A.on_invalid": '"hold"',
    "rule.A.max_hold": '"0.2 s"',
    "rule.A.modes": '["drive"]',
    "rule.A.tags": '["safety"]',
    "rule.A.keep": '["angle"]',
    "rule.A.action.name": '"Turn"',
    "rule.A.action.angle": '"60 deg * side(rear[0] - rear[1])"',
    "rule.A.action.on_invalid.angle": '"60 deg"',
    "rule.A.test": '[{ given = { front = "1 m" }, at = [{ t = "0 s" }], expect = [{ t = "0 s", fires = false }] }]',
}


def quoted(text):
    """A TOML string with every character escaped that TOML does not allow in one."""
    return '"' + "".join(c if c.isprintable() and c not in '"\\' else f"\\U{ord(c):08x}" for c in text) + '"'


LEAVES = st.one_of(
    st.integers().map(str),
    st.integers(2**60, 2**2000).map(str),
    st.sampled_from(["9" * 5000, "0x" + "f" * 400, "inf", "-inf", "nan", "1e400", "-0.0", "true", "false", "[]", "{}"]),
    st.sampled_from(["1979-05-27T07:32:00Z", "1979-05-27", "07:32:00"]),
    st.floats().map(repr).filter(lambda text: text not in ("inf", "nan")),
    st.text(st.characters(codec="utf-8"), max_size=20).map(quoted),
    st.sampled_from(["\0", "\x1b[31m", "\x7f", "\u202e", "a" * 5000, "min(front) < 0.4 m\0", "0.4 m\n", "1e309 m"]).map(
        quoted
    ),
    st.sampled_from(["(" * 300, "a and " * 300, "0.4 " + "m" * 3000, "near" * 500, "front[" + "9" * 300 + "]"]).map(
        quoted
    ),
    st.integers(1, 400).map(lambda depth: "[" * depth + "]" * depth),
)
VALUES = st.recursive(
    LEAVES,
    lambda inner: st.one_of(
        st.lists(inner, max_size=3).map(lambda parts: f"[{', '.join(parts)}]"),
        st.lists(inner, max_size=3).map(lambda ps: "{" + ", ".join(f"k{i} = {p}" for i, p in enumerate(ps)) + "}"),
    ),
    max_leaves=5,
)
KEYS = st.one_of(
    st.text(st.characters(codec="utf-8"), max_size=10).map(quoted),
    st.sampled_from(["x" * 3000, ".".join("a" * 200), '""', "rule.A", "rule.B", "include", "threshold", "__class__"]),
)


@st.composite
def files(draw):
    """The text of a rule file, with a few values and keys of it replaced, added or left out."""
    entries = dict(SOUND)
    for key in draw(st.lists(st.sampled_from(sorted(SOUND)), max_size=3)):
        entries[key] = draw(VALUES)
    if draw(st.booleans()):
        where = draw(
            st.sampled_from(
                ["", "rule.A.", "rule.A.action.", "alias.", "threshold.", "rule.", "rule.A.action.on_invalid."]
            )
        )
        entries[where + draw(KEYS)] = draw(VALUES)
    for key in draw(st.lists(st.sampled_from(sorted(SOUND)), max_size=2)):
        entries.pop(key, None)
    return "".join(f"{key} = {value}\n" for key, value in entries.items())


def read(file, text):
    """Load and examine a rule file; the faults."""
    file.write_text(text, encoding="utf-8")
    start = time.process_time()
    faults = examine_rules(file, ENVIRONMENT, ACTIONS).faults
    try:
        load_rules(file, ENVIRONMENT, ACTIONS)
    except InputError as error:
        assert error.faults
        assert any(not fault.warning for fault in faults)
    else:
        assert all(fault.warning for fault in faults)
    assert all(isinstance(fault, Fault) and str(fault) for fault in faults)
    assert time.process_time() - start < 10.0  # of CPU time, against hangs
    return faults


@settings(max_examples=150, deadline=None)
@given(files())
def test_any_value_at_any_key_is_refused_or_loads(tmp_path_factory, text):
    read(tmp_path_factory.getbasetemp() / "values.toml", text)


@pytest.mark.soak
@settings(max_examples=20_000, deadline=None)
@given(files())
def test_any_value_at_any_key_is_refused_or_loads_for_long(tmp_path_factory, text):
    read(tmp_path_factory.getbasetemp() / "values.toml", text)


HOSTILE = {
    "an integer of 10,000 digits": ("priority = 5", "priority = " + "9" * 10_000),
    "a key of 20,000 parts": ("priority = 5", "priority = 5\n" + ".".join("a" * 20_000) + " = 1"),
    "deep nesting": ("priority = 5", "priority = " + "[" * 5000 + "]" * 5000),
    "NUL": ("0.4 m", "0.4 m\\u0000"),
    "a raw NUL": ("0.4 m", "0.4 m\0"),
    "a terminal's escape": ("A]", '"\\u001b[31mA"]'),
}


@pytest.mark.parametrize("what", HOSTILE)
def test_hostile_files_are_refused_on_the_command_line(what, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    old, new = HOSTILE[what]
    text = 'format = "reflex/1"\n[rule.A]\nwhen = "min(front) < 0.4 m"\npriority = 5\naction = { name = "Stop" }\n'
    assert old in text
    file = tmp_path / "rules" / "hostile.toml"
    file.parent.mkdir()
    file.write_text(text.replace(old, new), encoding="utf-8")
    start = time.process_time()
    code = call(["check", str(file)])
    assert time.process_time() - start < 20.0  # of CPU time, against hangs
    out, err = capsys.readouterr()
    assert code == 2
    assert f"{file.name}:" in out + err
    assert "Traceback" not in out + err
    assert "defect" not in out + err
    assert all(c.isprintable() or c == "\n" for c in out + err)
