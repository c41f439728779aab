"""TOML with places: file, line and column of each key; what is not TOML is refused."""

import sys
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocs_bt.base.errors import InputError
from rocs_bt.base.toml_table import read_toml

FILE = Path("robot.toml")


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ('a = "b', "robot.toml:1: "),
        ("a = 1\na = 2\nb = 3", "robot.toml:2:6: "),
        ("[x", "robot.toml:1: "),
        ("a = [1,", "robot.toml:1: "),
        ("a = nope\n", "robot.toml:1:5: "),
    ],
)
def test_what_is_not_toml_is_placed(text, place):
    with pytest.raises(InputError) as error:
        read_toml(FILE, text)
    assert str(error.value).startswith(place)
    assert "not valid TOML" in str(error.value)


def test_a_missing_file_is_an_input_error(tmp_path):
    with pytest.raises(InputError, match="cannot read the file: No such file"):
        read_toml(tmp_path / "none.toml")


def test_bytes_that_are_no_text_are_an_input_error(tmp_path):
    (tmp_path / "bad.toml").write_bytes(b"a = \xff")
    with pytest.raises(InputError, match="not UTF-8"):
        read_toml(tmp_path / "bad.toml")


@given(st.text(alphabet="abz=[]{}\"'\n\t #.,0159-_\\", max_size=80))
def test_any_text_is_toml_or_an_input_error(text):
    try:
        table = read_toml(FILE, text)
        for key in table.data:
            assert table.position(key)[0] >= 0
    except InputError as error:
        assert error.faults[0].file == FILE


@given(
    st.lists(
        st.tuples(st.sampled_from("abcdef"), st.sampled_from(["1", '"x"', "[1,\n2]", '"""\nq = 1\n"""', "{z = 1}"]))
    )
)
def test_the_place_of_every_key_is_its_line(items):
    items = list(dict(items).items())
    lines, expected = [], {}
    for key, value in items:
        expected[key] = "\n".join(lines).count("\n") + (2 if lines else 1)
        lines.append(f"{key} = {value}")
    table = read_toml(FILE, "\n".join(lines))
    assert {key: table.position(key)[0] for key in expected} == expected


HOSTILE = {
    "dotted key": "\n" + ".".join("a" * 20_000) + " = 1\n",
    "dotted header": "\n[" + " . ".join("a" * 20_000) + "]\n",
    "dotted key in a table": "\nx = { " + ".".join("a" * 20_000) + " = 1 }\n",
    "quoted parts": "\n" + ".".join(["'a'"] * 20_000) + " = 1\n",
    "digits": "\nx = " + "1" * 10_000 + "\n",
    "digits with underscores": "\nx = [1" + "_1" * 10_000 + "]\n",
    "hexadecimal digits": "\n[a]\nx = [0x" + "f" * 10_000 + "]\n",
    "the first beyond 64 bits": "\nx = 9223372036854775808\n",
    "lists": "\nx = " + "[" * 150 + "]" * 150 + "\n",
    "many lists": "\nx = " + "[" * 20_000 + "\n",
    "many tables": "\nx = " + "{ a = " * 20_000 + "\n",
}
WORDS = {
    "d": (":2:", "a key has more than 100 parts."),
    "q": (":2:", "a key has more than 100 parts."),
    "digits": (":2", "an integer has more than 64 bits. Write at most 18 digits."),
    "hexadecimal digits": (":3:1: ", "an integer has more than 64 bits."),
    "the first beyond 64 bits": (":2:1: ", "an integer has more than 64 bits."),
    "lists": (":2:", "tables and lists nest too deep: 100 levels at most."),
    "many": (":2:", "tables and lists nest too deep: 100 levels at most."),
}


class Steps:
    """Counts the lines that are executed: work, whatever the machine does meanwhile."""

    def __init__(self):
        self.count = 0

    def __enter__(self):
        self._before = sys.gettrace()
        sys.settrace(self._trace)
        return self

    def __exit__(self, *error):
        sys.settrace(self._before)

    def _trace(self, frame, event, argument):
        self.count += 1
        return self._trace


@pytest.mark.parametrize("name", HOSTILE)
def test_what_would_take_minutes_is_refused_at_once(name):
    key = max((k for k in WORDS if name.startswith(k)), key=len)
    place, words = WORDS[key]
    with pytest.raises(InputError) as caught, Steps() as steps:
        read_toml(Path("f.toml"), HOSTILE[name])
    assert str(caught.value).startswith(f"f.toml{place}")
    assert words in str(caught.value)
    # A few for each character; without a bound the parts of a key are compared by the million.
    assert steps.count < 50_000 + 5 * len(HOSTILE[name])


def test_the_bounds_themselves_are_no_fault():
    key = ".".join("a" * 100)
    told = f'# {key}.a\ns = """\n{key}.a\n"""\n'  # neither a comment nor a text has keys
    text = f"{told}{key} = 9223372036854775807\n[b]\nx = -9223372036854775808\ny = {'[' * 90}{']' * 90}\n"
    assert read_toml(Path("f.toml"), text).position_of(("b", "x")) == (7, 1)


@pytest.mark.parametrize(
    ("line", "column"),
    [
        ('[" ]" . "a]b"]', 1),
        ("[" + " " * 30_000 + '"a]b"' + " " * 30_000 + "]", 1),
        ("  [[ 'x.y' ]] # here", 3),
        ("\"a=b\".'c#d' = 1", 1),
    ],
    ids=["brackets in names", "spaces", "array", "marks in names"],
)
def test_any_key_has_its_place(line, column):
    with Steps() as steps:
        table = read_toml(Path("f.toml"), f"first = 1\n{line}\n")
    assert (2, column) in table.positions.values()
    assert steps.count < 200_000  # a few for each character
